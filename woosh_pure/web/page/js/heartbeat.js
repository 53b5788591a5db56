// The page's side of the dead-man switch: sends a press, and heartbeats while a control is held. The server decides whether the
// robot is driven; this side never sends a beat by mistake. Pure: clock, sending and buffer are arguments.
//
// idle -> press() -> held -> release(), end() or a gap -> over -> all controls released -> idle
// In "over" no beat is sent: the control must be released and pressed again.

export const BEAT_SECONDS = 0.1;
export const GAP_SECONDS = 0.35; // a longer pause of this page (frozen, asleep, busy) ends the drive
export const BUFFER_LIMIT = 2048; // unsent bytes; a beat behind more would be late

export class Heartbeat {
  constructor({ send, now, buffered }) {
    this.send = send;
    this.now = now;
    this.buffered = buffered;
    this.state = "idle";
    this.reason = "";
    this.seq = 0;
    this.skipped = 0;
    this.last = 0;
    this.command = { vx: 0, wz: 0 };
    this.onchange = () => {};
  }

  get held() {
    return this.state === "held";
  }

  // A control was pressed. False if it must be released first.
  press(vx, wz) {
    if (this.state !== "idle") return false;
    this.command = { vx, wz };
    this.last = this.now();
    this.change("held", "");
    this.say("press");
    return true;
  }

  // The control was moved: the next beat has the new velocity.
  steer(vx, wz) {
    if (this.held) this.command = { vx, wz };
  }

  // Called about every 100 ms.
  tick() {
    if (!this.held) return;
    const gap = this.now() - this.last;
    if (gap > GAP_SECONDS) {
      this.end("gap");
      return;
    }
    this.last = this.now();
    if (this.buffered() > BUFFER_LIMIT) {
      this.skipped += 1;
      return;
    }
    this.say("beat");
  }

  // Released by the person: the next press is accepted.
  release() {
    if (this.held) this.send({ t: "release" });
    if (this.state !== "idle") this.change("idle", "");
  }

  // End for another reason while a control may still be held.
  end(reason) {
    if (!this.held) return;
    this.send({ t: "release" });
    this.change("over", reason);
  }

  // The server has ended the drive: no release is sent.
  ended(reason) {
    if (this.held) this.change("over", reason);
  }

  say(t) {
    this.seq += 1;
    this.send({ t, seq: this.seq, at: this.now(), vx: this.command.vx, wz: this.command.wz });
  }

  change(state, reason) {
    this.state = state;
    this.reason = reason;
    this.onchange(state, reason);
  }
}
