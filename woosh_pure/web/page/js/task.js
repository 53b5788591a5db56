// What is under way: progress, pause, go on, cancel; and how it ended, until it is closed.

import { button, byId, el, fill, icon, show } from "./dom.js";
import { number, onLanguage, t, word } from "./i18n.js";
import { attempt } from "./toast.js";

export class Task {
  constructor({ store, rest }) {
    this.store = store;
    this.rest = rest;
    this.box = byId("task");
    this.closed = null; // id of the goal whose end was closed
    this.shape = ""; // what is built; progress only moves the bar
    store.on("goal", () => this.render());
    onLanguage(() => {
      this.shape = "";
      this.render();
    });
  }

  render() {
    const goal = this.store.get("goal");
    const hidden = !goal || (!goal.running && goal.id === this.closed);
    show(this.box, !hidden);
    if (hidden) return;
    const shape = JSON.stringify([goal.id, goal.state, goal.pauses]);
    if (shape !== this.shape) this.build(goal);
    this.shape = shape;
    const known = Number.isFinite(goal.percent);
    show(this.bar, goal.running);
    if (known) this.bar.value = goal.percent;
    else this.bar.removeAttribute("value");
    this.bar.setAttribute("aria-label", goal.text ?? t("values.task"));
    const note = [known && goal.running ? `${number(goal.percent, 0)} %` : "", goal.progress || goal.end || "",
      goal.by ? t("task.by", { by: goal.by }) : ""];
    this.note.textContent = note.filter(Boolean).join(" · ");
  }

  build(goal) {
    const running = goal.running;
    const { good } = goal;
    const call = (method, path) => () => attempt(() => this.rest.call(method, path, null, { timeout: 20 }));
    const id = encodeURIComponent(goal.id);
    this.bar = el("progress", { max: 100 });
    this.note = el("p", { class: "quiet", "aria-live": "off" });
    const buttons = running ? [
      goal.state === "paused"
        ? button(t("task.resume"), call("POST", `goals/${id}/resume`), { kind: "primary", id: "resume" })
        : goal.pauses ? button(t("task.pause"), call("POST", `goals/${id}/pause`), { id: "pause" }) : null,
      button(t("task.cancel"), call("DELETE", `goals/${id}`), { id: "cancel" }),
    ] : [button(t("task.close"), () => {
      this.closed = goal.id;
      this.render();
    }, { kind: "plain" })];
    this.box.className = `card task ${running ? "running" : good ? "ok" : "bad"}`;
    fill(
      this.box,
      el("div", { class: "head" }, icon(running ? "wait" : good ? "ok" : "no"), el("strong", {}, word("goal", goal.state)),
        el("span", { class: "grow" }, goal.text ?? "")),
      this.bar, this.note, el("div", { class: "row" }, ...buttons),
    );
  }
}
