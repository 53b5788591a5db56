// The card of the current goal: progress, pause, resume, cancel, and then its end until it is closed.

import { button, byId, el, fill, icon, say, show } from "./dom.js";
import { changed, number, onLanguage, t, word } from "./i18n.js";
import { isOld } from "./freshness.js";
import { seconds } from "./live_connection.js";
import { ICONS } from "./log_tab.js";
import { attempt } from "./toast.js";
import { whatText, whoText } from "./command_words.js";
import { endText } from "./reason_words.js";

const SHOWN_SECONDS = 20; // seconds for which a good end is shown
const STANDING_SECONDS = 2; // then the page says that a robot on its way stands

export class TaskCard {
  constructor({ store, rest }) {
    this.store = store;
    this.rest = rest;
    this.box = byId("task");
    this.seen = null; // id of the goal that was last seen running here
    this.closed = null;
    this.before = undefined; // id of the goal that had ended before the page was opened, "" if none: its end is not shown
    store.on("goal", (goal) => (this.before ??= goal && !goal.running ? goal.id : ""));
    store.on("goal lost", () => this.render());
    store.on("anew", () => ([this.seen, this.closed, this.before] = [null, null, undefined])); // a new server numbers its goals anew
    onLanguage(() => this.render());
    setInterval(() => this.progress(), 500);
  }

  render() {
    const goal = this.store.get("goal");
    if (goal?.running && goal.id !== this.seen) {
      this.seen = goal.id;
      // A person who started it far down the list would not see the card.
      if (goal.who === this.store.get("hello")?.you) byId("panel").scrollTop = 0;
    }
    // A goal can begin and end between two messages to a slow page; its end is shown, too.
    const endSeen = this.before === undefined || [this.before, this.closed].includes(goal?.id);
    const hidden = !goal || (!goal.running && endSeen);
    show(this.box, !hidden);
    if (hidden) return;
    const what = whatText(goal);
    if (changed(this, goal.id, goal.state, goal.pauses, goal.reasons, goal.stands_still, what)) { // progress only moves the bar
      this.later(goal);
      this.build(goal, what);
    }
    this.progress();
  }

  // A good end disappears by itself; a bad one stays until it is closed.
  later(goal) {
    clearTimeout(this.timer);
    if (goal.running || goal.kind === "bad") return;
    this.timer = setTimeout(() => this.close(goal.id), SHOWN_SECONDS * 1000);
  }

  close(id) {
    this.closed = id;
    this.render();
  }

  progress() {
    const goal = this.store.get("goal");
    if (!goal?.running || !this.bar) return;
    this.buttons.disabled = this.store.get("lost")?.who === "server";
    const { metres_left: left, percent } = goal;
    if (Number.isFinite(percent)) this.bar.value = percent;
    else this.bar.removeAttribute("value");
    const waits = this.store.get("robot")?.task?.state === "waiting for action";
    const stands = this.stands(goal) ? t("task.stands") : "";
    const now = waits ? t("task.waits") : this.ending === goal.id ? t("stop.asking") : stands;
    const text = now || (Number.isFinite(left) ? t("task.left", { n: number(left, 1) })
      : Number.isFinite(percent) ? `${number(percent, 0)} %` : "");
    say(this.note, [text, this.by(goal)].filter(Boolean).join(" · "));
  }

  // Whether it has not moved for a while on its way. A robot that stands is not said to do so without a fresh velocity.
  stands(goal) {
    const { vx = 0, wz = 0 } = this.store.get("velocity") ?? {};
    const old = isOld("velocity", this.store.get("ages")?.of("velocity", seconds()));
    if (old || goal.state === "paused" || Math.hypot(vx, wz) > 0.01 || this.moving !== goal.id) this.movedAt = seconds();
    this.moving = goal.id;
    return seconds() - this.movedAt > STANDING_SECONDS;
  }

  by(goal) {
    if (goal.who && goal.who === this.store.get("hello")?.you) return t("task.you");
    return goal.who ? t("task.by", { by: whoText(goal.who) }) : "";
  }

  build(goal, what) {
    const { running, kind } = goal;
    const call = (method, path) => () => attempt(() => this.rest.call(method, path, null, { timeout: 20 }));
    const id = encodeURIComponent(goal.id);
    this.bar = running ? el("progress", { max: 100, "aria-label": what }) : null;
    this.note = running ? el("p", { class: "quiet", "aria-live": "off" }) : null;
    this.buttons = running ? el("fieldset", { class: "row" },
      goal.state === "paused"
        ? button(t("task.resume"), call("POST", `goals/${id}/resume`), { kind: "primary", id: "resume" })
        : goal.pauses ? button(t("task.pause"), call("POST", `goals/${id}/pause`), { id: "pause" }) : null,
      button(t("task.cancel"), async () => {
        this.ending = goal.id;
        await call("POST", `goals/${id}/cancel`)();
        this.ending = null;
      }, { id: "cancel" })) : null;
    const close = running ? null : button("×", () => this.close(goal.id), { kind: "close", "aria-label": t("task.close") });
    const end = running ? "" : endText(goal);
    this.box.className = `card task ${kind}`;
    fill(
      this.box,
      el("div", { class: "head" }, icon(ICONS[kind]),
        el("span", { class: "grow" }, el("strong", {}, what), ` · ${word("goal", goal.state)}`), close),
      end ? el("p", { class: "quiet" }, end) : null,
      this.bar, this.note, this.buttons,
    );
  }
}
