// The part of the map that the canvas shows. Pure: metres in the map (y up) <-> CSS pixels (y down).

export const MIN_SCALE = 2;
export const MAX_SCALE = 400; // pixels for a metre

const bounded = (scale) => Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale));

export class MapViewport {
  constructor() {
    this.x = 0; // the metre in the middle of the canvas
    this.y = 0;
    this.scale = 40;
    this.width = 1;
    this.height = 1;
  }

  resize(width, height) {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  panBy(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  centre(x, y) {
    this.x = x;
    this.y = y;
  }

  // The point under (px, py) stays there.
  zoomAt(px, py, factor) {
    const [x, y] = this.toWorld(px, py);
    this.scale = bounded(this.scale * factor);
    const [nx, ny] = this.toWorld(px, py);
    this.x += x - nx;
    this.y += y - ny;
  }

  // Two fingers moved from (a, b) to (c, d): the point between them stays between them.
  pinch(a, b, c, d) {
    const before = Math.hypot(a[0] - b[0], a[1] - b[1]);
    const after = Math.hypot(c[0] - d[0], c[1] - d[1]);
    this.panBy((c[0] + d[0] - a[0] - b[0]) / 2, (c[1] + d[1] - a[1] - b[1]) / 2);
    if (before > 1 && after > 1) this.zoomAt((c[0] + d[0]) / 2, (c[1] + d[1]) / 2, after / before);
  }

  // Show all of {left, right, bottom, top}, metres, in the part of the canvas that is not covered: pixels at each edge.
  fit({ left, right, bottom, top }, covered = {}) {
    const edge = { left: 16, right: 16, bottom: 16, top: 16, ...covered };
    const wide = Math.max(this.width - edge.left - edge.right, 40);
    const high = Math.max(this.height - edge.top - edge.bottom, 40);
    this.scale = bounded(Math.min(wide / Math.max(right - left, 0.5), high / Math.max(top - bottom, 0.5)));
    this.centre((left + right) / 2, (bottom + top) / 2);
    this.panBy((edge.left - edge.right) / 2, (edge.top - edge.bottom) / 2);
  }
}

// A round length that is drawn `least` to 2.5 times as many pixels wide: {metres, pixels}.
export function scaleBar(scale, least = 60) {
  const rough = least / scale;
  const power = 10 ** Math.floor(Math.log10(rough));
  const metres = [1, 2, 5, 10].map((step) => step * power).find((step) => step >= rough * 0.999) ?? 10 * power;
  return { metres: Number(metres.toPrecision(2)), pixels: metres * scale };
}
