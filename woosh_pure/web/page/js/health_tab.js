// The tab Health: whether the robot would move, faults with advice, values with their age, and the plots.

import { byId, el, fill, icon, say } from "./dom.js";
import { ageWords, isOld } from "./freshness.js";
import { stateText } from "./header.js";
import { degrees, inDegrees, number, onLanguage, t, word } from "./i18n.js";
import { seconds } from "./live_connection.js";
import { distinct, said, todoOf, whyOf } from "./reason_words.js";

const ROWS = ["state", "mode", "battery", "velocity", "position", "scan", "odometer", "task", "map"];
const FEED = { state: "status", mode: "status", position: "pose", task: "status", odometer: "odometer" };
const LEVEL = { severe: "severe", error: "severe", fault: "severe", warning: "warning", warn: "warning" };

export class HealthTab {
  constructor({ store, ages }) {
    this.store = store;
    this.ages = ages;
    this.ready = el("section", { class: "card" });
    this.faults = el("section", { class: "card", "aria-live": "polite" });
    this.table = el("section", { class: "card" });
    this.plots = el("section", { class: "card", id: "plots" });
    fill(byId("tab-health"), this.ready, this.faults, this.table, this.plots);
    store.on("readiness lost", () => this.renderReady());
    store.on("faults", () => this.renderFaults());
    store.on("tab lost", () => this.tick());
    onLanguage(() => this.renderAll());
    setInterval(() => this.tick(), 500);
  }

  renderAll() {
    this.renderReady();
    this.renderFaults();
    this.cells = new Map(ROWS.map((row) => [row, { value: el("td"), age: el("td", { class: "age" }) }]));
    const rows = ROWS.map((row) =>
      el("tr", {}, el("th", { scope: "row" }, t(`values.${row}`)), this.cells.get(row).value, this.cells.get(row).age));
    fill(this.table, el("h2", {}, t("values.title")), el("table", {}, el("tbody", {}, ...rows)));
    this.tick();
  }

  renderReady() {
    const gone = this.store.get("lost") !== null; // earlier readiness is out of date
    const readiness = gone ? null : this.store.get("readiness");
    const refused = readiness?.reasons.some(({ key }) => key === "refused"); // it is not known why
    const answer = refused && readiness.answer === "yes" ? "unknown" : { yes: "yes", no: "no" }[readiness?.answer] ?? "unknown";
    const kind = { yes: "ok", no: "bad", unknown: "warn" }[answer];
    const reasons = distinct(readiness?.reasons).map((reason) => {
      const todo = reason.key === "fault" ? "" : todoOf(reason); // it names this page
      return el("li", {}, el("strong", {}, whyOf(reason)), todo ? el("p", { class: "quiet" }, todo) : null);
    });
    fill(this.ready, el("h2", {}, t("ready.title")),
      el("p", { class: `answerline ${kind}` }, icon({ yes: "ok", no: "no", unknown: "ask" }[answer]), t(`ready.${answer}`)),
      reasons.length ? el("ul", { class: "plainlist" }, ...reasons) : null);
  }

  renderFaults() {
    const faults = this.store.get("faults");
    const list = (faults?.active ?? []).map((fault) => this.fault(fault));
    fill(this.faults, el("h2", {}, t("faults.title")),
      list.length ? el("ul", { class: "plainlist" }, ...list) : el("p", { class: "quiet" }, t(faults?.known ? "faults.none" : "faults.unheard")));
  }

  fault(fault) {
    const level = LEVEL[String(fault.level ?? "").toLowerCase()] ?? "notice";
    return el("li", { class: level === "severe" ? "bad" : "warn" }, el("strong", {}, said(fault)),
      el("p", { class: "quiet" }, [t(`faults.${level}`), t("faults.code", { code: fault.code })].join(" · ")),
      el("p", {}, `${t("todo.title")} ${t("faults.look")}`));
  }

  value(row) {
    const { store } = this;
    const robot = store.get("robot") ?? {};
    const velocity = store.get("velocity");
    const pose = store.get("pose");
    const rates = store.get("rates") ?? {};
    switch (row) {
      case "state": return stateText(store) ?? t("unknown");
      case "mode": return word("mode", robot.mode);
      case "battery": return battery(store.get("battery"));
      case "velocity": return velocity ? `${number(velocity.vx, 2)} m/s, ${number(inDegrees(velocity.wz), 0)} °/s` : t("unknown");
      case "position": return pose ? `${number(pose.x, 2)}, ${number(pose.y, 2)} m, ${degrees(pose.yaw)}°` : t("unknown");
      case "scan": return Number.isFinite(rates.scan) ? t("values.perhertz", { n: number(rates.scan, 1) }) : t("unknown");
      case "odometer": return Number.isFinite(store.get("odometer")) ? `${number(store.get("odometer"), 1)} m` : t("unknown");
      case "task": return task(robot.task);
      default: return mapText(store.get("map"));
    }
  }

  tick() {
    if (!this.cells || this.store.get("tab") !== "health") return;
    const now = seconds();
    const gone = this.store.get("lost") !== null;
    for (const [row, { value, age }] of this.cells) {
      const feed = FEED[row] ?? row;
      const old = this.ages.of(feed, now);
      say(value, this.value(row));
      say(age, row === "map" ? "" : ageText(old));
      value.classList.toggle("old", gone || (row !== "map" && isOld(feed, old)));
    }
  }
}

function battery(value) {
  if (!Number.isFinite(value?.percent)) return t("unknown");
  const parts = [`${value.percent} %`];
  if (Number.isFinite(value.voltage)) parts.push(`${number(value.voltage, 1)} V`);
  if (Number.isFinite(value.current)) parts.push(`${number(value.current, 1)} A`);
  if (value.charging) parts.push(t("top.charging"));
  return parts.join(", ");
}

function ageText(age) {
  const { key, values } = ageWords(age);
  return t(key, values);
}

const task = (value) => (value ? [value.destination, word("goal", value.state)].filter(Boolean).join(" · ") : "–");

function mapText(map) {
  if (!map) return t("unknown");
  const [wide, high] = [map.width, map.height].map((cells) => number(cells * map.resolution, 1));
  return `${wide} × ${high} m`;
}
