// The lowest layers of the map: the grid's picture and the costmap, coloured for light or dark.

const colours = (names) => {
  const style = getComputedStyle(document.documentElement);
  return names.map((name) => rgb(style.getPropertyValue(`--${name}`).trim()));
};

// "#rrggbb" -> [r, g, b]
const rgb = (text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) || 0);

function surface(width, height) {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  return canvas;
}

export class MapBackground {
  constructor(store, rest, changed, progress) {
    this.store = store;
    this.rest = rest;
    this.changed = changed;
    this.progress = progress;
    this.meta = null;
    this.source = null; // ImageBitmap as it came
    this.picture = null; // canvas as it is drawn
    this.cost = null; // {canvas, frame}
    this.costShown = false;
    this.loading = 0;
    store.on("map", (meta) => this.load(meta));
    store.on("costmap", (frame) => this.takeCost(frame));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.colour());
  }

  // The corners of the map in metres; null without one.
  get bounds() {
    if (!this.meta) return null;
    const { width, height, resolution, origin } = this.meta;
    const corners = [[0, 0], [width, 0], [0, height], [width, height]].map(([column, row]) =>
      turned(origin, column * resolution, row * resolution));
    const xs = corners.map((corner) => corner[0]);
    const ys = corners.map((corner) => corner[1]);
    return { left: Math.min(...xs), right: Math.max(...xs), bottom: Math.min(...ys), top: Math.max(...ys) };
  }

  async load(meta) {
    if (meta.version === this.meta?.version) return;
    this.loading += 1;
    const mine = this.loading;
    try {
      const blob = await this.rest.blob("map.png", (part) => mine === this.loading && this.progress(part));
      const source = await createImageBitmap(blob);
      if (mine !== this.loading) return; // a newer one is loading
      this.meta = meta;
      this.source = source;
      this.colour();
      this.store.set("ground", meta);
    } catch (error) {
      if (mine === this.loading) this.store.set("ground", null);
      console.warn(error.message);
    } finally {
      if (mine === this.loading) this.progress(null);
    }
  }

  // Grey 254 is free, 0 occupied, 205 not known.
  colour() {
    if (!this.source) return;
    const { width, height } = this.source;
    const canvas = surface(width, height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(this.source, 0, 0);
    const image = context.getImageData(0, 0, width, height);
    const [free, unknown, wall] = colours(["map-free", "map-unknown", "map-wall"]);
    const table = Array.from({ length: 256 }, (_, grey) => (grey > 220 ? free : grey < 110 ? wall : unknown));
    const { data } = image;
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = table[data[i]];
      data[i] = r;
      data[i + 1] = g;
      data[i + 2] = b;
      data[i + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    this.picture = canvas;
    this.changed();
  }

  takeCost(frame) {
    if (!frame) {
      this.cost = null;
      this.changed();
      return;
    }
    const { width, height, cells } = frame;
    const canvas = surface(width, height);
    const context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    const [[r, g, b]] = colours(["map-cost"]);
    for (let row = 0; row < height; row += 1) {
      for (let column = 0; column < width; column += 1) {
        const cost = cells[row * width + column];
        if (cost === 0 || cost > 100) continue;
        const at = 4 * ((height - 1 - row) * width + column);
        image.data.set([r, g, b, 24 + Math.round(1.1 * cost)], at);
      }
    }
    context.putImageData(image, 0, 0);
    this.cost = { canvas, frame };
    this.changed();
  }

  draw(context, view) {
    if (this.picture) {
      const { width, height, resolution, origin } = this.meta;
      raster(context, view, this.picture, origin, width * resolution, height * resolution);
    }
    if (this.cost && this.costShown) {
      const { canvas, frame } = this.cost;
      const origin = [frame.x, frame.y, frame.yaw];
      raster(context, view, canvas, origin, frame.width * frame.resolution, frame.height * frame.resolution);
    }
  }
}

const turned = ([x, y, yaw = 0], dx, dy) => [
  x + dx * Math.cos(yaw) - dy * Math.sin(yaw),
  y + dx * Math.sin(yaw) + dy * Math.cos(yaw),
];

// A picture whose lower left corner is at `origin`, metres.
function raster(context, view, picture, [x, y, yaw = 0], wide, high) {
  const [px, py] = view.toScreen(x, y);
  context.save();
  context.translate(px, py);
  context.rotate(-yaw);
  context.imageSmoothingEnabled = view.scale * (wide / picture.width) < 1;
  context.drawImage(picture, 0, -high * view.scale, wide * view.scale, high * view.scale);
  context.restore();
}
