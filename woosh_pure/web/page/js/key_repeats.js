// The repeats of the key that was pressed last, a sign that it is still held: they take the way that its key-up would take.
// Pure; times are seconds.
//
// They count only where they are dependable: after some have come, until another key goes down or up, because only the key
// pressed last repeats. A system without repeats sends none, and nothing is missed. The first one comes after 0.25 to 2 s:
// how long it takes is learnt from the keys pressed before.

const SLACK_SECONDS = 0.4; // a busy computer delivers late
const MIN_REPEATS = 3;

export class KeyRepeats {
  constructor() {
    this.delay = Infinity; // from a press to its first repeat
    this.clear();
  }

  clear() {
    this.at = null; // the last press or repeat
    this.count = 0;
    this.longest = 0; // between two repeats
  }

  press(at) {
    this.clear();
    this.at = at;
  }

  repeat(at) {
    if (this.at === null) return;
    if (this.count === 0) this.delay = at - this.at;
    else this.longest = Math.max(this.longest, at - this.at);
    this.at = at;
    this.count += 1;
  }

  // Whether repeats are missing. Then the delay is learnt anew, in case the system has stopped to send any.
  missing(now) {
    if (this.at === null) return false;
    const due = this.count < MIN_REPEATS ? 2 * this.delay : 4 * this.longest;
    if (now - this.at <= due + SLACK_SECONDS) return false;
    this.delay = Infinity;
    this.clear();
    return true;
  }
}
