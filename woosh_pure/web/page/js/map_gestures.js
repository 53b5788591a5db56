// Fingers and mouse on the map: one finger moves it, two zoom, a short press is a tap. While a pose is being placed, one
// finger places it. Pure: takes pointer events and calls `actions`.

const TAP_PIXELS = 8;
const TAP_SECONDS = 0.6;

export class MapGestures {
  // actions: pan(dx, dy) pinch(a, b, c, d) tap(p) placing() -> bool; begin(p) drag(p) drop(p) undo()
  constructor(actions) {
    this.actions = actions;
    this.fingers = new Map(); // id -> [x, y]
    this.start = null; // {id, point, at}: a press that may still be a tap
    this.dragging = null; // id of the finger that places
  }

  down(id, point, at) {
    this.fingers.set(id, point);
    if (this.fingers.size > 1) {
      this.start = null;
      if (this.dragging !== null) this.actions.undo();
      this.dragging = null;
      return;
    }
    if (this.actions.placing()) {
      this.dragging = id;
      this.actions.begin(point);
    } else {
      this.start = { id, point, at };
    }
  }

  move(id, point) {
    const before = this.fingers.get(id);
    if (before === undefined) return;
    if (this.fingers.size === 2) {
      const [other] = [...this.fingers].filter(([key]) => key !== id);
      this.actions.pinch(before, other[1], point, other[1]);
    } else if (this.dragging === id) {
      this.actions.drag(point);
    } else if (this.fingers.size === 1) {
      this.one(before, point);
    }
    this.fingers.set(id, point);
  }

  one(before, point) {
    if (this.start) {
      const away = Math.hypot(point[0] - this.start.point[0], point[1] - this.start.point[1]);
      if (away < TAP_PIXELS) return;
      before = this.start.point;
      this.start = null;
    }
    this.actions.pan(point[0] - before[0], point[1] - before[1]);
  }

  up(id, point, at) {
    this.fingers.delete(id);
    if (this.dragging === id) {
      this.dragging = null;
      this.actions.drop(point);
    } else if (this.start?.id === id && at - this.start.at < TAP_SECONDS) {
      this.actions.tap(point);
    }
    if (this.start?.id === id) this.start = null;
  }

  // Cancelled by the system: no tap, and no place.
  cancel(id) {
    this.fingers.delete(id);
    if (this.dragging === id) this.actions.undo();
    if (this.dragging === id) this.dragging = null;
    if (this.start?.id === id) this.start = null;
  }
}

// The heading of a drag from (ax, ay) to (bx, by), metres; `otherwise` for a short drag.
export function headingOf(ax, ay, bx, by, enough, otherwise) {
  if (Math.hypot(bx - ax, by - ay) < enough) return otherwise;
  return Math.atan2(by - ay, bx - ax);
}

// The mark nearest to a tap, within `reach` metres; null when there is none.
export function nearest(marks, x, y, reach) {
  let best = null;
  let least = reach;
  for (const mark of marks ?? []) {
    if (!Number.isFinite(mark.x) || !Number.isFinite(mark.y)) continue;
    const away = Math.hypot(mark.x - x, mark.y - y);
    if (away <= least) [best, least] = [mark, away];
  }
  return best;
}
