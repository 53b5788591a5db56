// STOP: one touch without a question, and an answer that says whether the robot stands still. Tries the open connection, a
// call, a call without a session and a beacon, until one is confirmed; if none is, it stops again when the server is back,
// until the answer is closed. Stopping twice does no harm.

import { button, byId, el, fill, icon, show } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { stopText } from "./reason_words.js";

const CALL_SECONDS = 0.1; // seconds without a confirmation: then a call follows
const ALL_WAYS_SECONDS = 0.3; // then all other ways
const RED_BUTTON_SECONDS = 0.9; // then show the hint to the red button
const SLOW_SECONDS = 2; // then show it even for a begun stop without a result
const STOP_SECONDS = 25; // a stop waits for the robot's standstill

// Classify the answer. Pure.
export function verdict(answer) {
  if (answer?.stands_still === true) return { key: "stop.stands", kind: "ok", icon: "ok" };
  if (answer?.stands_still === false) return { key: "stop.moves", kind: "bad", icon: "warn" };
  return { key: "stop.unsure", kind: "warn", icon: "ask" };
}

const NO_ANSWER = { key: "stop.slow", kind: "bad", icon: "warn" };

export class StopButton {
  constructor({ store, rest, link }) {
    Object.assign(this, { store, rest, link });
    this.number = 0;
    this.shown = null;
    this.timers = [];
    this.box = byId("stop-answer");
    const stop = byId("stop");
    const early = stop.dataset.early === "pressed"; // before this module was loaded: see early_stop.js
    delete stop.dataset.early;
    // pointerdown, not click: a finger that slips off must not undo it.
    stop.addEventListener("pointerdown", (event) => {
      if (event.button === 0) this.press();
    });
    stop.addEventListener("click", (event) => {
      if (event.detail === 0) this.press(); // by the keyboard
    });
    store.on("stop", (message) => this.takeState(message));
    store.on("hello", () => this.shown && !this.over && this.press());
    onLanguage(() => this.shown && this.answer(this.shown));
    if (early) this.press();
  }

  press() {
    this.store.set("stopping", true); // a running drive ends
    this.number += 1;
    this.begun = this.over = false;
    this.waiting = new Set(); // ways by which an answer may still come
    this.timers.forEach(clearTimeout);
    this.answer({ key: "stop.asking", kind: "info", icon: "wait" });
    const mine = this.number;
    const socket = this.link.send({ t: "stop", n: mine });
    if (socket) this.waiting.add("socket");
    const slow = () => this.shown?.key === "stop.failed" || this.answer(NO_ANSWER); // which says less
    const later = (seconds, act) => setTimeout(() => mine === this.number && act(), seconds * 1000);
    this.timers = [
      later(socket ? CALL_SECONDS : 0, () => this.begun || this.call(mine, true)),
      later(ALL_WAYS_SECONDS, () => this.begun || this.other(mine)),
      later(RED_BUTTON_SECONDS, () => this.begun || slow()),
      later(SLOW_SECONDS, () => this.over || !this.shown || slow()), // not if it was closed
    ];
  }

  // A call; without a session it carries nothing that a server could refuse.
  async call(mine, session) {
    this.waiting.add(session);
    try {
      this.end(mine, await this.rest.json("POST", "stop", null, { timeout: STOP_SECONDS, session }));
    } catch (error) {
      const stopped = "stands_still" in (error.problem ?? {}); // an error, but the stop was carried out
      if (stopped) this.end(mine, error.problem);
      else this.failed(mine, session, error.message);
    }
  }

  other(mine) {
    if (this.tried === mine) return;
    this.tried = mine;
    this.call(mine, false);
    navigator.sendBeacon?.(`${this.rest.base}stop`);
  }

  failed(mine, way, text) {
    if (mine !== this.number) return;
    this.waiting.delete(way);
    if (this.begun || this.over) return;
    this.other(mine);
    if (this.shown && !this.waiting.has(true) && !this.waiting.has(false)) this.answer({ key: "stop.failed", kind: "bad", icon: "warn", text });
  }

  // The server's messages over the open connection.
  takeState(message) {
    if (message.n !== this.number) return;
    this.begun = true;
    if (message.state === "done") this.end(message.n, message);
    else if (!this.over && this.shown?.key !== "stop.asking") this.answer({ key: "stop.asking", kind: "info", icon: "wait" });
  }

  end(mine, report) {
    if (mine !== this.number) return;
    this.begun = this.over = true;
    this.answer({ ...verdict(report), report });
  }

  answer(shown) {
    this.shown = shown;
    const { key, kind, icon: name, report, text } = shown;
    const more = text ?? (report ? stopText(report) : "");
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
