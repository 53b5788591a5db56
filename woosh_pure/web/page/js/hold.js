// What a person holds to drive: the pad, keys or a gamepad, one at a time.
//
// The end of a hold is not always seen: while a menu or a dialog of the browser is open the key-up goes there, and no
// pointer-up comes while a second button of the mouse is held. So the drive ends with whatever is pressed or touched beside
// the control, and with whatever the browser puts before the page. Only a new press begins another drive.
//
// A control has owns(event), whether a press is its own, and forget(), called at each end that is not its release.

const INTERRUPTIONS = ["beforeprint", "dragenter", "dragstart", "fullscreenchange", "pointerlockchange"];

export class Hold {
  // ready(): whether a press may drive now;  limits(): {vx, wz};  changed(state, reason): see heartbeat.js
  constructor({ heartbeat, ready, limits, changed }) {
    Object.assign(this, { heartbeat, ready, limits, changed });
    this.control = null; // the one that is held
    heartbeat.onchange = (state, reason) => {
      changed(state, reason);
      if (state === "over") this.forget();
    };
    this.listen();
  }

  // Called with the held control's command. False if it does not drive, and has to be pressed anew.
  press(control, command) {
    if (this.control !== null) {
      this.end("other");
      return false;
    }
    if (!this.ready()) return false;
    this.control = control;
    return this.heartbeat.press(command.vx, command.wz);
  }

  steer(control, command) {
    if (control !== this.control) return;
    this.heartbeat.steer(command.vx, command.wz);
    this.changed("held", "");
  }

  release(control) {
    if (control !== this.control) return;
    this.control = null;
    this.heartbeat.release();
  }

  end(reason) {
    this.heartbeat.end(reason);
  }

  forget() {
    const { control } = this;
    this.control = null;
    control?.forget();
    this.heartbeat.release();
  }

  listen() {
    addEventListener("keydown", (event) => this.beside(event, event.key === "Escape" ? "stopped" : "other"));
    addEventListener("pointerdown", (event) => this.beside(event, "other"));
    // A menu that the page has prevented takes nothing: a finger that rests on the pad asks for one.
    addEventListener("contextmenu", (event) => event.defaultPrevented || this.end("other"));
    for (const name of INTERRUPTIONS) addEventListener(name, () => this.end("other"));
    addEventListener("blur", () => this.end("blur"));
    document.addEventListener("visibilitychange", () => document.hidden && this.end("hidden"));
    addEventListener("pagehide", () => this.end("hidden"));
    document.addEventListener("freeze", () => this.end("hidden"));
  }

  beside(event, reason) {
    if (!this.control?.owns(event)) this.end(reason);
  }
}
