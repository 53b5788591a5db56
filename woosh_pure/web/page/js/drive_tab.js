// The tab Drive: by pad, keys or gamepad, if the server allows it and the warning was confirmed. Heartbeats are sent only
// while a control is held.

import { button, byId, el, fill, say, show } from "./dom.js";
import { BEAT_SECONDS, Heartbeat } from "./heartbeat.js";
import { inDegrees, number, onLanguage, t } from "./i18n.js";
import { Hold } from "./hold.js";
import { Gamepad, Keys } from "./keys_and_gamepad.js";
import { seconds } from "./live_connection.js";
import { DrivePad } from "./drive_pad.js";
import { isDriveKey } from "./steering.js";
import { attempt, toast } from "./toast.js";
import { warning } from "./driving_warning.js";
import { causeText, hindrance, kindText } from "./reason_words.js";

// The server's reasons -> keys of the dictionary.
const REASONS = {
  silent: "silent", late: "late", "slow link": "slow", "no lease": "unleased", stopped: "stopped", busy: "busy",
  over: "ended", "not connected": "lost", "not allowed": "off", "not confirmed": "unconfirmed",
  released: "again", "pressed twice": "again", "not a new press": "again", "released early": "again",
};
// Why a drive has ended, a key or a function, in the present language.
const whyText = (why) => (typeof why === "string" ? t(`drive.${why}`) : why()).replace(/[.。]$/, "");

export class DriveTab {
  constructor({ store, link, lease, leaseBox }) {
    Object.assign(this, { store, link, lease, leaseBox });
    this.on = false;
    this.speed = 0.5;
    this.note = ""; // reason of the last end, until the control is let go
    this.heartbeat = new Heartbeat({ send: (message) => link.send(message), now: seconds, buffered: () => link.buffered });
    this.hold = new Hold({
      heartbeat: this.heartbeat, ready: () => this.ready(), limits: () => this.limits,
      changed: (state, reason) => {
        if (state !== "idle") this.note = reason;
        this.show();
      },
    });
    this.pad = new DrivePad(this.hold);
    this.keys = new Keys(this.hold, () => this.on && store.get("tab") === "drive");
    this.gamepad = new Gamepad(this.hold);
    this.build();
    store.on("drive", (message) => this.takeState(message));
    store.on("hello", () => this.switch(false)); // a new session needs a new confirmation
    store.on("link", (state) => state !== "open" && this.hold.end("lost"));
    store.on("lost", (lost) => lost && this.hold.end("lost"));
    store.on("stopping", () => this.hold.end("stopped"));
    store.on("lease", (now) => !now?.yours && this.hold.end("unleased"));
    store.on("tab", (tab) => tab !== "drive" && this.hold.end("hidden"));
    store.on("lease lost readiness goal", () => this.on && this.show());
    onLanguage(() => this.render());
    for (const name of ["pointerup", "keyup"]) {
      addEventListener(name, ({ target, code }) => (this.pad.root.contains(target) || isDriveKey(code)) && this.letGo());
    }
    setInterval(() => this.beat(), BEAT_SECONDS * 1000);
  }

  get limits() {
    const { vx, wz } = this.store.get("hello")?.limits ?? { vx: 0, wz: 0 };
    return { vx: vx * this.speed, wz: wz * this.speed };
  }

  build() {
    this.status = el("p", { class: "drivestate", role: "status" });
    this.asking = button("", () => attempt(() => this.lease.need()), { kind: "primary", id: "drive-ask" });
    const keep = () => (this.slider.value = String(this.speed));
    this.slider = el("input", {
      type: "range", min: "0.2", max: "1", step: "0.1", value: String(this.speed), id: "speed",
      oninput: () => (this.scrolls ? keep() : (this.speed = Number(this.slider.value))),
      onkeydown: () => (this.scrolls = false),
      onpointerdown: () => ([this.before, this.scrolls] = [this.speed, false]),
      onpointercancel: () => {
        [this.speed, this.scrolls] = [this.before, true]; // the browser scrolls: the rest of this touch sets nothing
        keep();
      },
    });
    this.root = byId("tab-drive");
    this.place = byId("pad-row"); // first in the panel: notes appear below it
  }

  // Whether a press may drive now. It takes the control if nobody has it.
  ready() {
    if (!this.on) return false;
    if (this.lease.held) toast(this.lease.otherText, "bad");
    else if (!this.lease.yours) this.lease.say("ask");
    return !this.lease.held;
  }

  beat() {
    const { held } = this.gamepad;
    if (this.on && this.store.get("tab") === "drive" && !document.hidden) this.gamepad.poll();
    if (held && !this.gamepad.held) this.letGo();
    this.pad.stays();
    this.keys.check(seconds());
    this.heartbeat.tick();
  }

  letGo() {
    this.note = "";
    this.show();
  }

  takeState({ state, reasons, reason, kind }) {
    if (state === "driving" || state === "opening") return;
    const key = REASONS[reason] ?? "ended";
    const cause = () => causeText(reasons) || (REASONS[reason] ? "" : kindText(kind)) || t(`drive.${key}`);
    const task = this.store.get("goal")?.running ? () => t("why.busy") : "stopped";
    const why = reasons?.[0]?.key === "call" ? task : cause;
    this.heartbeat.ended(why);
    if (state === "refused") toast(whyText(why), "bad");
  }

  // First the warning, then control, then the switch.
  ask() {
    fill(this.root, warning((agreed) => (agreed ? this.enable() : this.render())), this.leaseBox);
    byId("warning-title").focus();
    byId("warning").scrollIntoView();
  }

  async enable() {
    this.render();
    const asked = await attempt(() => this.lease.need());
    if (asked !== null && this.link.send({ t: "confirm" })) this.switch(true);
    byId("panel").scrollTop = 0;
    if (this.on) this.store.set("closer", true); // zoom in to the surroundings
  }

  switch(on) {
    if (!on) this.hold.end("hidden");
    if (this.on && !on) this.store.set("closer", false);
    this.on = on;
    this.render();
  }

  render() {
    const hello = this.store.get("hello");
    if (hello && !hello.allow_driving) {
      fill(this.place);
      fill(this.root, el("section", { class: "card" }, el("h2", {}, t("drive.off")), el("p", {}, t("drive.offhow"))), this.leaseBox);
      return;
    }
    this.pad.root.setAttribute("aria-label", t("drive.pad"));
    this.pad.root.setAttribute("role", "application");
    const parts = this.on
      ? [el("label", { class: "slider" }, el("span", {}, t("drive.speed")), this.slider),
        el("p", { class: "quiet center" }, t("drive.pad")), el("p", { class: "quiet center wide" }, t("drive.keys")),
        button(t("drive.disable"), () => this.switch(false), { kind: "plain", id: "drive-off" })]
      : [el("section", { class: "card" }, el("h2", {}, t("drive.title")), el("p", {}, t("drive.warning.1")),
        button(t("drive.enable"), () => this.ask(), { kind: "primary", id: "drive-on" }))];
    fill(this.place, ...(this.on ? [this.pad.root, el("div", {}, this.status, this.asking)] : []));
    fill(this.root, ...parts, this.leaseBox);
    this.show();
  }

  // Why a press would be refused now; "" if no reason is known.
  get hindered() {
    return hindrance(this.store) || (this.store.get("goal")?.running ? t("why.busy") : "");
  }

  show() {
    const { state, command } = this.heartbeat;
    const held = state === "held";
    const other = !held && this.lease.held;
    let text = this.hindered || t("drive.idle");
    if (held) text = t("drive.driving", { vx: number(command.vx, 2), wz: number(inDegrees(command.wz), 0) });
    else if (other) text = this.lease.otherText;
    else if (this.note) text = t("drive.over", { why: whyText(this.note) });
    say(this.status, text);
    say(this.asking.firstChild, t("lease.ask"));
    show(this.asking, other);
    this.status.classList.toggle("driving", held);
    this.status.classList.toggle("bad", !held && text !== t("drive.idle"));
  }
}
