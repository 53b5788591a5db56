// The pad for driving: hold and drag. Reports x right, y up, -1..1, and the reason of its release.
//
// Positions are relative to the pad's place at the press. Moving or resizing a held pad ends the drive.

import { el } from "./dom.js";

const STILL = 0.5; // pixels, or percent of zoom

export class DrivePad {
  // told: press(x, y), steer(x, y), release(), taken(), moved()
  constructor(told) {
    this.told = told;
    this.pointer = null;
    this.began = null; // the view at the press; null once the pad has moved
    this.knob = el("span", { class: "knob" });
    this.root = el("div", { class: "pad" }, el("span", { class: "cross" }), this.knob);
    const { root } = this;
    root.addEventListener("pointerdown", (event) => this.down(event));
    root.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.pointer && this.stays()) this.told.steer(...this.where(event));
    });
    root.addEventListener("pointerup", (event) => this.up(event, "release"));
    root.addEventListener("pointercancel", (event) => this.up(event, "taken"));
    root.addEventListener("lostpointercapture", (event) => this.up(event, "taken"));
    root.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  down(event) {
    if (this.pointer !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
    event.preventDefault();
    this.pointer = event.pointerId;
    this.box = this.root.getBoundingClientRect();
    this.began = this.view();
    this.root.setPointerCapture(event.pointerId);
    this.root.classList.add("held");
    this.told.press(...this.where(event));
  }

  up(event, why) {
    if (event.pointerId !== this.pointer) return;
    this.pointer = null;
    this.root.classList.remove("held");
    this.place(0, 0);
    this.told[why]();
  }

  // The pad's place, and the page's zoom.
  view() {
    const { left, top, width, height } = this.root.getBoundingClientRect();
    const { scale = 1, offsetLeft = 0, offsetTop = 0 } = globalThis.visualViewport ?? {};
    return [left, top, width, height, innerWidth, innerHeight, offsetLeft, offsetTop, 100 * scale, 100 * devicePixelRatio];
  }

  // Whether the pad is still in its place. Also called before each beat. Reports a move once.
  stays() {
    if (this.pointer === null) return true;
    if (this.began === null) return false;
    const now = this.view();
    if (this.began.every((value, i) => Math.abs(value - now[i]) <= STILL)) return true;
    this.began = null;
    this.told.moved();
    return false;
  }

  where(event) {
    const { box } = this;
    const radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / (0.75 * radius);
    let y = -(event.clientY - box.top - radius) / (0.75 * radius);
    const length = Math.hypot(x, y);
    if (length > 1) [x, y] = [x / length, y / length];
    this.place(x, y);
    return [x, y];
  }

  place(x, y) {
    this.knob.style.transform = `translate(${Math.round(x * 70)}px, ${Math.round(-y * 70)}px)`;
  }
}
