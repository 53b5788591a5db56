// Keys and gamepad for driving. Both report held controls, and never press again by themselves.

import { fromGamepad, fromKeys, isDriveKey } from "./steering.js";

const EDITABLE = new Set(["INPUT", "TEXTAREA", "SELECT"]);

export class Keys {
  // told: press(codes), steer(codes), release();  active() -> whether keys drive now
  constructor(active, told) {
    this.codes = new Set();
    this.active = active;
    this.told = told;
    addEventListener("keydown", (event) => this.down(event));
    addEventListener("keyup", (event) => this.up(event));
  }

  down(event) {
    if (!isDriveKey(event.code) || !this.active()) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (EDITABLE.has(event.target.tagName) || event.target.getAttribute?.("role") === "tab") return;
    event.preventDefault(); // the page does not scroll
    if (event.repeat || this.codes.has(event.code)) return;
    this.codes.add(event.code);
    if (this.codes.size === 1) this.told.press(this.codes);
    else this.told.steer(this.codes);
  }

  up(event) {
    if (!this.codes.delete(event.code)) return;
    if (this.codes.size === 0) this.told.release();
    else this.told.steer(this.codes);
  }

  clear() {
    this.codes.clear();
  }
}

export class Gamepad {
  // told: press(command), steer(command), release(); polled with each beat
  constructor(told, pads = () => navigator.getGamepads?.() ?? []) {
    this.told = told;
    this.pads = pads;
    this.held = false;
  }

  poll(limits) {
    const pad = [...this.pads()].find((one) => one?.connected && one.mapping === "standard");
    const command = pad ? fromGamepad(pad, limits) : null;
    if (command && this.held) this.told.steer(command);
    else if (command) {
      this.held = true;
      this.told.press(command);
    } else if (this.held) {
      this.held = false;
      this.told.release();
    }
  }
}

export { fromKeys };
