// The pad for driving: hold and drag. A control of a Hold.
//
// Positions are relative to the pad's place at the press. Moving or resizing a held pad ends the drive.

import { el } from "./dom.js";
import { fromStick } from "./steering.js";

const MAX_SHIFT = 0.5; // pixels, or percent of zoom

export class DrivePad {
  constructor(hold) {
    this.hold = hold;
    this.pointer = null;
    this.knob = el("span", { class: "knob" });
    this.root = el("div", { class: "pad" }, el("span", { class: "cross" }), this.knob);
    const { root } = this;
    root.addEventListener("pointerdown", (event) => this.down(event));
    root.addEventListener("pointermove", (event) => this.move(event));
    root.addEventListener("pointerup", (event) => this.up(event));
    root.addEventListener("pointercancel", (event) => this.taken(event));
    root.addEventListener("lostpointercapture", (event) => this.taken(event));
    root.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  owns(event) {
    return event.pointerId === this.pointer;
  }

  down(event) {
    if (this.pointer !== null) {
      this.hold.end("other"); // a second finger, or the pointer-up was not seen
      return;
    }
    if (event.pointerType === "mouse" && event.button !== 0) return;
    event.preventDefault();
    this.box = this.root.getBoundingClientRect();
    if (!this.hold.press(this, this.command(event))) return;
    this.pointer = event.pointerId;
    this.began = this.view();
    this.root.setPointerCapture(event.pointerId);
    this.root.classList.add("held");
    this.place(event);
  }

  // Neither a button that goes down nor one that comes up has an event of its own while another is held.
  move(event) {
    if (!this.owns(event)) return;
    if (event.pointerType !== "touch" && event.buttons !== 1) this.hold.end("other");
    else if (this.stays()) {
      this.hold.steer(this, this.command(event));
      this.place(event);
    }
  }

  up(event) {
    if (!this.owns(event)) return;
    this.hold.release(this);
    this.forget();
  }

  taken(event) {
    if (this.owns(event)) this.hold.end("taken");
  }

  forget() {
    this.pointer = null;
    this.root.classList.remove("held");
    this.knob.style.transform = "";
  }

  // The pad's place, and the page's zoom.
  view() {
    const { left, top, width, height } = this.root.getBoundingClientRect();
    const { scale = 1, offsetLeft = 0, offsetTop = 0 } = globalThis.visualViewport ?? {};
    return [left, top, width, height, innerWidth, innerHeight, offsetLeft, offsetTop, 100 * scale, 100 * devicePixelRatio];
  }

  // Whether the pad is still in its place. Also called before each beat.
  stays() {
    if (this.pointer === null) return true;
    const now = this.view();
    if (this.began.every((value, i) => Math.abs(value - now[i]) <= MAX_SHIFT)) return true;
    this.hold.end("moved");
    return false;
  }

  command(event) {
    return fromStick(...this.stick(event), this.hold.limits());
  }

  // x right, y up, -1..1
  stick(event) {
    const { box } = this;
    const radius = box.width / 2;
    const x = (event.clientX - box.left - radius) / (0.75 * radius);
    const y = -(event.clientY - box.top - radius) / (0.75 * radius);
    const length = Math.max(1, Math.hypot(x, y));
    return [x / length, y / length];
  }

  place(event) {
    const [x, y] = this.stick(event);
    const reach = 0.32 * this.box.width;
    this.knob.style.transform = `translate(${Math.round(x * reach)}px, ${Math.round(-y * reach)}px)`;
  }
}
