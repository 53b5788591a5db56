// STOP: one touch, no question, and an answer that says what stands still and what does not.

import { button, byId, el, fill, icon, show } from "./dom.js";
import { onLanguage, t } from "./i18n.js";

const SLOW = 2; // seconds: then it is said that there is no answer yet
const LIMIT = 25; // a stop watches the robot until it stands

// Pure: which of the four answers this is.
export function verdict(answer) {
  if (answer?.stands_still === true) return { key: "stop.stands", kind: "ok", icon: "ok" };
  if (answer?.stands_still === false) return { key: "stop.moves", kind: "bad", icon: "warn" };
  return { key: "stop.unsure", kind: "warn", icon: "ask" };
}

export class Stop {
  constructor({ store, rest }) {
    this.store = store;
    this.rest = rest;
    this.number = 0;
    this.shown = null;
    this.box = byId("stop-answer");
    const stop = byId("stop");
    const early = stop.dataset.early === "pressed"; // before this module had come: see early_stop.js
    delete stop.dataset.early;
    // pointerdown, not click: a finger that slips off must not undo it.
    stop.addEventListener("pointerdown", (event) => {
      if (event.button === 0) this.press();
    });
    stop.addEventListener("click", (event) => {
      if (event.detail === 0) this.press(); // by the keyboard
    });
    onLanguage(() => this.shown && this.answer(this.shown));
    if (early) this.press();
  }

  async press() {
    this.store.set("stopping", true); // whoever drives lets go
    this.number += 1;
    const mine = this.number;
    this.answer({ key: "stop.asking", kind: "info", icon: "wait" });
    const slow = setTimeout(() => mine === this.number && this.answer({ key: "stop.slow", kind: "bad", icon: "warn" }), SLOW * 1000);
    try {
      const report = await this.rest.json("POST", "stop", null, { timeout: LIMIT });
      if (mine === this.number) this.answer({ ...verdict(report), report });
    } catch (error) {
      if (mine === this.number) this.answer({ key: "stop.failed", kind: "bad", icon: "warn", text: error.message });
    } finally {
      clearTimeout(slow);
    }
  }

  answer(shown) {
    this.shown = shown;
    const { key, kind, icon: name, report, text } = shown;
    const more = text ?? report?.text ?? "";
    this.box.className = `answer ${kind}`;
    fill(
      this.box,
      icon(name),
      el("div", {}, el("strong", {}, t(key)), more ? el("p", { class: "quiet" }, more) : null),
      button("×", () => this.close(), { kind: "close", "aria-label": t("stop.close") }),
    );
    show(this.box);
    clearTimeout(this.timer);
    if (kind === "ok") this.timer = setTimeout(() => this.close(), 12000);
  }

  close() {
    this.shown = null;
    show(this.box, false);
  }
}
