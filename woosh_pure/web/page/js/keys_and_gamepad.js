// Keys and gamepad for driving, two controls of a Hold. They never press again by themselves.

import { KeyRepeats } from "./key_repeats.js";
import { fromGamepad, fromKeys, isDriveKey } from "./steering.js";

const EDITABLE = new Set(["INPUT", "TEXTAREA", "SELECT"]);

export class Keys {
  // active(): whether keys drive now
  constructor(hold, active) {
    this.hold = hold;
    this.active = active;
    this.codes = new Set(); // held
    this.unseen = new Set(); // held when a drive ended: their key-up may never be seen
    this.repeats = new KeyRepeats();
    addEventListener("keydown", (event) => this.down(event), true); // before the hold: a key that ends one begins none
    addEventListener("keyup", (event) => this.up(event));
  }

  owns(event) {
    if (!isDriveKey(event.code) || event.ctrlKey || event.metaKey || event.altKey) return false;
    return !EDITABLE.has(event.target.tagName) && event.target.getAttribute?.("role") !== "tab";
  }

  down(event) {
    if (!this.active() || !this.owns(event)) return;
    event.preventDefault(); // the page does not scroll
    const at = event.timeStamp / 1000;
    if (event.repeat) this.repeats.repeat(at);
    // One that went down again without a key-up may be held all the time: this press ends the doubt, the next one drives.
    if (event.repeat || this.codes.has(event.code) || this.unseen.delete(event.code)) return;
    this.repeats.press(at);
    this.codes.add(event.code);
    const command = fromKeys(this.codes, this.hold.limits());
    if (this.codes.size > 1) this.hold.steer(this, command);
    else if (!this.hold.press(this, command)) this.forget();
  }

  up(event) {
    this.repeats.clear();
    this.unseen.delete(event.code);
    if (!this.codes.delete(event.code)) return;
    if (this.codes.size === 0) this.hold.release(this);
    else this.hold.steer(this, fromKeys(this.codes, this.hold.limits()));
  }

  // Called before each beat.
  check(now) {
    if (this.codes.size > 0 && this.repeats.missing(now)) this.hold.end("unseen");
  }

  forget() {
    this.codes.forEach((code) => this.unseen.add(code));
    this.codes.clear();
  }
}

export class Gamepad {
  constructor(hold, pads = () => navigator.getGamepads?.() ?? []) {
    this.hold = hold;
    this.pads = pads;
    this.held = false; // also when a drive has ended: it has to be seen released
  }

  owns() {
    return false; // it sends no events
  }

  // Called before each beat.
  poll() {
    const pad = [...this.pads()].find((one) => one?.connected && one.mapping === "standard");
    const command = pad ? fromGamepad(pad, this.hold.limits()) : null;
    const pressed = command !== null && !this.held;
    this.held = command !== null;
    if (pressed) this.hold.press(this, command);
    else if (this.held) this.hold.steer(this, command);
    else this.hold.release(this);
  }

  forget() {}
}
