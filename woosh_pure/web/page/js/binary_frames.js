// Decodes the binary frames of the live connection (scan, camera, costmap), little-endian. Returns null for
// a frame that is incomplete or of an unknown kind.

export const SCAN = 1;
export const CAMERA = 2;
export const COSTMAP = 3;

const HEADER = 24;
const SOURCES = ["color", "depth"];

export function decode(buffer) {
  if (buffer.byteLength < 2) return null;
  const view = new DataView(buffer);
  switch (view.getUint8(0)) {
    case SCAN:
      return scan(view, buffer);
    case CAMERA:
      return camera(view, buffer);
    case COSTMAP:
      return costmap(view, buffer);
    default:
      return null;
  }
}

function floats(view, offset, names) {
  const values = {};
  for (const name of names) {
    values[name] = view.getFloat32(offset, true);
    if (!Number.isFinite(values[name])) return null;
    offset += 4;
  }
  return values;
}

function scan(view, buffer) {
  if (buffer.byteLength < HEADER) return null;
  const count = view.getUint16(2, true);
  const head = floats(view, 4, ["x", "y", "yaw", "angleMin", "angleIncrement"]);
  if (head === null || buffer.byteLength < HEADER + 2 * count) return null;
  const points = new Float32Array(2 * count);
  let seen = 0;
  for (let i = 0; i < count; i += 1) {
    const centimetres = view.getUint16(HEADER + 2 * i, true);
    if (centimetres === 0 || centimetres === 0xffff) continue; // no measurement
    const angle = head.yaw + head.angleMin + i * head.angleIncrement;
    points[2 * seen] = head.x + (centimetres / 100) * Math.cos(angle);
    points[2 * seen + 1] = head.y + (centimetres / 100) * Math.sin(angle);
    seen += 1;
  }
  return { kind: "scan", x: head.x, y: head.y, yaw: head.yaw, points: points.subarray(0, 2 * seen) };
}

function camera(view, buffer) {
  const source = SOURCES[view.getUint8(1)];
  if (source === undefined || buffer.byteLength < 3) return null;
  return { kind: "camera", source, jpeg: buffer.slice(2) };
}

function costmap(view, buffer) {
  if (buffer.byteLength < HEADER) return null;
  const width = view.getUint16(2, true);
  const height = view.getUint16(4, true);
  const row = view.getUint16(6, true);
  const head = floats(view, 8, ["resolution", "x", "y", "yaw"]);
  const rows = (buffer.byteLength - HEADER) / width;
  if (head === null || !(rows >= 1 && Number.isInteger(rows)) || row + rows > height) return null;
  return { kind: "costmap", width, height, row, rows, ...head, cells: new Uint8Array(buffer, HEADER) };
}

// Joins the parts of a costmap. `take` returns the whole costmap with the last part, else null.
export class CostmapParts {
  constructor() {
    this.whole = null;
  }

  take(part) {
    const { width, height, row } = part;
    if (row === 0) this.whole = { ...part, rows: 0, cells: new Uint8Array(width * height) };
    const { whole } = this;
    if (whole === null || whole.rows !== row || whole.width !== width || whole.height !== height) return (this.whole = null);
    whole.cells.set(part.cells, row * width);
    whole.rows += part.rows;
    if (whole.rows < height) return null;
    this.whole = null;
    return whole;
  }
}
