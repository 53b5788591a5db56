// Values over the last minutes for the plots, and the robot's trail on the map; both bounded.

export class TimeSeries {
  constructor(seconds = 300, limit = 1200) {
    this.seconds = seconds;
    this.limit = limit;
    this.points = []; // [time, value]; a value of null is a gap
  }

  add(time, value) {
    const number = Number.isFinite(value) ? value : null;
    this.points.push([time, number]);
    const oldest = time - this.seconds;
    let drop = 0;
    while (drop < this.points.length && this.points[drop][0] < oldest) drop += 1;
    drop = Math.max(drop, this.points.length - this.limit);
    if (drop > 0) this.points.splice(0, drop);
  }

  get last() {
    return this.points.length ? this.points[this.points.length - 1][1] : null;
  }

  // [smallest, largest], or null when there is no value.
  range() {
    let low = Infinity;
    let high = -Infinity;
    for (const [, value] of this.points) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    return low <= high ? [low, high] : null;
  }
}

// The robot's trail: a point every few centimetres; a jump begins a new line. Older points are thinned.
export class Trail {
  constructor(step = 0.05, jump = 1.0, limit = 3000) {
    this.step = step;
    this.jump = jump;
    this.limit = limit;
    this.lines = [];
    this.count = 0;
  }

  add(x, y) {
    const line = this.lines[this.lines.length - 1];
    const last = line?.[line.length - 1];
    const away = last ? Math.hypot(x - last[0], y - last[1]) : Infinity;
    if (away < this.step) return false;
    if (away > this.jump) this.lines.push([[x, y]]);
    else line.push([x, y]);
    this.count += 1;
    if (this.count > this.limit) this.thin();
    return true;
  }

  thin() {
    const lines = this.lines.map((line) => line.filter((_, i) => i % 2 === 0 || i === line.length - 1));
    this.lines = lines.filter((line, i) => line.length > 1 || i === lines.length - 1).slice(-200);
    this.count = this.lines.reduce((sum, line) => sum + line.length, 0);
  }
}
