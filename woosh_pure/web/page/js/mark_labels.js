// Places the names of marks on the map so that none covers another name or a pin. A name without space is left out until
// the map is zoomed in. Pure: pixels, y down.

const ROW_PIXELS = 20;

class Taken {
  constructor() {
    this.rows = new Map(); // boxes by screen row, for speed: a thousand marks are drawn twenty times a second
  }

  rowsOf(box) {
    const rows = [];
    for (let row = Math.floor(box.top / ROW_PIXELS); row <= Math.floor(box.bottom / ROW_PIXELS); row += 1) rows.push(row);
    return rows;
  }

  free(box) {
    const apart = (other) =>
      other.right <= box.left || other.left >= box.right || other.bottom <= box.top || other.top >= box.bottom;
    return this.rowsOf(box).every((row) => (this.rows.get(row) ?? []).every(apart));
  }

  add(box) {
    for (const row of this.rowsOf(box)) this.rows.set(row, [...(this.rows.get(row) ?? []), box]);
  }
}

// pins: [{text, x, y, first}], the tips of the pins; width(text) -> pixels. `covered` is a box that gets no name. Returns
// [{text, x, y}]: middle and baseline.
export function placeLabels(pins, width, covered = null) {
  const taken = new Taken();
  if (covered) taken.add(covered);
  for (const { x, y } of pins) taken.add({ left: x - 10, right: x + 10, top: y - 27, bottom: y + 1 });
  const labels = [];
  for (const { text, x, y } of [...pins].sort((a, b) => Boolean(b.first) - Boolean(a.first))) {
    const half = width(text) / 2 + 3;
    const boxOf = ([mx, my]) => ({ left: mx - half, right: mx + half, top: my - 13, bottom: my + 5 });
    const spots = [[x, y + 17], [x, y - 32], [x + half + 12, y - 9], [x - half - 12, y - 9]];
    const spot = spots.find((each) => taken.free(boxOf(each)));
    if (!spot) continue;
    taken.add(boxOf(spot));
    labels.push({ text, x: spot[0], y: spot[1] });
  }
  return labels;
}
