// Plots of battery, velocity and rates over the last minutes. Recorded while the page is open, drawn while in view.

import { byId, el, fill } from "./dom.js";
import { inDegrees, number, onLanguage, t } from "./i18n.js";
import { seconds } from "./live_connection.js";
import { TimeSeries } from "./time_series.js";

const SECONDS = 300;
const PLOTS = [
  { key: "battery", least: 5, digits: 0, read: (store) => store.get("battery")?.percent },
  { key: "velocity", least: 0.2, digits: 2, read: (store) => store.get("velocity")?.vx },
  { key: "turning", least: 20, digits: 0, read: (store) => inDegrees(store.get("velocity")?.wz ?? NaN) },
  { key: "rates", least: 2, digits: 1, read: (store) => store.get("rates")?.pose },
];

export class Plots {
  constructor({ store }) {
    this.store = store;
    this.series = new Map(PLOTS.map(({ key }) => [key, new TimeSeries(SECONDS, 700)]));
    this.root = byId("plots");
    onLanguage(() => this.build());
    setInterval(() => this.sample(), 500);
    store.on("tab", () => this.draw());
  }

  build() {
    this.parts = new Map(PLOTS.map(({ key }) => {
      const now = el("strong");
      const range = el("span", { class: "quiet" });
      return [key, { canvas: el("canvas", { role: "img", class: "plot" }), now, range }];
    }));
    fill(this.root, el("h2", {}, t("plots.title")), ...PLOTS.map(({ key }) => {
      const { canvas, now, range } = this.parts.get(key);
      return el("figure", {}, el("figcaption", {}, el("span", { class: "grow" }, t(`plots.${key}`)), range, now), canvas);
    }));
    this.draw();
  }

  // A lost robot leaves a gap in the line.
  sample() {
    const gone = this.store.get("lost") !== null;
    for (const { key, read } of PLOTS) this.series.get(key).add(seconds(), gone ? null : read(this.store));
    this.draw();
  }

  draw() {
    if (!this.parts || this.store.get("tab") !== "health" || document.hidden) return;
    for (const plot of PLOTS) this.one(plot, this.series.get(plot.key), this.parts.get(plot.key));
  }

  one({ key, least, digits }, series, { canvas, now, range }) {
    const limits = series.range();
    const title = t(`plots.${key}`);
    if (limits === null) {
      canvas.setAttribute("aria-label", t("plots.empty", { title }));
      return;
    }
    const values = { now: number(series.last, digits), low: number(limits[0], digits), high: number(limits[1], digits) };
    canvas.setAttribute("aria-label", t("plots.spoken", { title, ...values }));
    now.textContent = values.now;
    range.textContent = `${values.low} … ${values.high}`;
    curve(canvas, series.points, scaleOf(limits, least), seconds());
  }
}

// The drawn range: at least `least`, so that noise is not magnified. Pure.
export function scaleOf([low, high], least) {
  const missing = Math.max(0, least - (high - low)) / 2;
  const margin = 0.08 * Math.max(least, high - low);
  return [low - missing - margin, high + missing + margin];
}

function curve(canvas, points, [low, high], now) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0) return;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.strokeStyle = style.getPropertyValue("--line").trim();
  context.lineWidth = 1;
  context.beginPath();
  for (let minute = 0; minute <= 5; minute += 1) {
    const x = Math.round(width - (minute * 60 * width) / SECONDS) - 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
  }
  context.stroke();
  const y = (value) => height - ((value - low) / (high - low)) * height;
  if (low < 0 && high > 0) {
    context.beginPath();
    context.moveTo(0, y(0));
    context.lineTo(width, y(0));
    context.stroke();
  }
  context.strokeStyle = style.color;
  context.lineWidth = 2;
  context.lineJoin = "round";
  context.beginPath();
  let pen = false;
  for (const [time, value] of points) {
    if (value === null) pen = false;
    else {
      const x = width - ((now - time) * width) / SECONDS;
      if (pen) context.lineTo(x, y(value));
      else context.moveTo(x, y(value));
      pen = true;
    }
  }
  context.stroke();
}
