// The pad: hold and drag. Tells x right, y up, -1..1, and why it was let go.

import { el } from "./dom.js";

export class Pad {
  // told: press(x, y), steer(x, y), release(), taken()
  constructor(told) {
    this.told = told;
    this.pointer = null;
    this.knob = el("span", { class: "knob" });
    this.root = el("div", { class: "pad" }, el("span", { class: "cross" }), this.knob);
    const { root } = this;
    root.addEventListener("pointerdown", (event) => this.down(event));
    root.addEventListener("pointermove", (event) => {
      if (event.pointerId === this.pointer) this.told.steer(...this.where(event));
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

  where(event) {
    const box = this.root.getBoundingClientRect();
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
