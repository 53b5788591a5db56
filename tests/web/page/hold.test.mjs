import assert from "node:assert/strict";
import { test } from "node:test";

import { Heartbeat } from "../../../woosh_pure/web/page/js/heartbeat.js";
import { Hold } from "../../../woosh_pure/web/page/js/hold.js";
import { KeyRepeats } from "../../../woosh_pure/web/page/js/key_repeats.js";
import { Gamepad, Keys } from "../../../woosh_pure/web/page/js/keys_and_gamepad.js";

// A page without a browser: events come from `fire`, on the window or the document.
function page() {
  const at = { capture: new EventTarget(), window: new EventTarget(), document: new EventTarget() };
  globalThis.addEventListener = (name, act, capture) => (capture ? at.capture : at.window).addEventListener(name, act);
  globalThis.document = Object.assign(at.document, { hidden: false });
  const w = { now: 100, sent: [], pads: [] };
  const heartbeat = new Heartbeat({ send: (m) => w.sent.push(m.t), now: () => w.now, buffered: () => 0 });
  w.reasons = [];
  w.hold = new Hold({
    heartbeat, ready: () => true, limits: () => ({ vx: 0.3, wz: 0.5 }),
    changed: (state, reason) => state === "over" && w.reasons.push(reason),
  });
  w.keys = new Keys(w.hold, () => true);
  w.gamepad = new Gamepad(w.hold, () => w.pads);
  w.fire = (name, more = {}, where = at.window) => {
    let prevented = false;
    for (const phase of where === at.window ? [at.capture, at.window] : [where]) {
      const event = new Event(name, { cancelable: true });
      if (prevented) event.preventDefault();
      for (const [key, value] of Object.entries({ target: { tagName: "BODY" }, timeStamp: 1000 * w.now, ...more })) {
        Object.defineProperty(event, key, { value });
      }
      prevented = !phase.dispatchEvent(event);
    }
  };
  w.down = (code, more = {}) => w.fire("keydown", { code, key: code, repeat: false, ...more });
  w.up = (code) => w.fire("keyup", { code, key: code });
  w.after = (seconds) => {
    w.now += seconds;
    w.gamepad.poll();
    w.keys.check(w.now);
    heartbeat.tick();
  };
  w.press = (held) => (w.pads = [{ connected: true, mapping: "standard", axes: [0, -1], buttons: [0, 0, 0, 0, { pressed: held }] }]);
  w.last = () => w.sent.at(-1);
  return w;
}

test("keys: a press, a beat each time, and a release with the last key", () => {
  const w = page();
  w.down("KeyW");
  w.after(0.1);
  w.down("KeyA");
  w.up("KeyW");
  w.after(0.1);
  w.up("KeyA");
  assert.deepEqual(w.sent, ["press", "beat", "beat", "release"]);
  assert.deepEqual(w.reasons, []);
});

const WAYS = {
  "a menu": (w) => w.fire("contextmenu"),
  "another key": (w) => w.down("KeyF"),
  "Alt": (w) => w.down("AltLeft", { altKey: true }),
  "the Command key": (w) => w.down("MetaLeft", { metaKey: true }),
  "the Menu key": (w) => w.down("ContextMenu"),
  "F10": (w) => w.down("F10"),
  "a drive key with Alt": (w) => w.down("ArrowLeft", { altKey: true }),
  "a drive key in a field": (w) => w.down("KeyD", { target: { tagName: "INPUT" } }),
  "a pointer": (w) => w.fire("pointerdown", { pointerId: 7 }),
  "a drag begins": (w) => w.fire("dragstart"),
  "a drag comes from elsewhere": (w) => w.fire("dragenter"),
  "the whole screen": (w) => w.fire("fullscreenchange"),
  "a lock of the pointer": (w) => w.fire("pointerlockchange"),
  "printing": (w) => w.fire("beforeprint"),
  "another window": (w) => w.fire("blur"),
  "leaving the page": (w) => w.fire("pagehide"),
  "freezing": (w) => w.fire("freeze", {}, document),
  "hiding": (w) => {
    document.hidden = true;
    w.fire("visibilitychange", {}, document);
    document.hidden = false;
  },
};

const CONTROLS = {
  key: { down: (w) => w.down("KeyA"), up: (w) => w.up("KeyA") },
  gamepad: { down: (w) => w.press(true), up: (w) => w.press(false) },
};

for (const [control, { down, up }] of Object.entries(CONTROLS)) {
  for (const [way, take] of Object.entries(WAYS)) {
    test(`${way} ends what a ${control} drives; only letting go and a new press drive again`, () => {
      const w = page();
      down(w);
      w.after(0.1);
      w.after(0.1);
      assert.equal(w.last(), "beat");
      take(w);
      assert.equal(w.last(), "release");
      const count = w.sent.length;
      for (let i = 0; i < 3; i += 1) w.after(0.1);
      if (control === "key") w.down("KeyA", { repeat: true });
      if (control === "key") w.down("KeyA"); // a system that does not mark its repeats
      w.after(0.1);
      assert.equal(w.sent.length, count, "nothing resumes while it is held");
      up(w);
      w.after(0.1);
      down(w);
      w.after(0.1);
      assert.equal(w.last(), "beat");
    });
  }
}

test("a menu that the page has prevented ends nothing: a finger that rests on the pad asks for one", () => {
  const w = page();
  w.down("KeyA");
  addEventListener("contextmenu", (event) => event.preventDefault(), true);
  w.fire("contextmenu");
  w.after(0.1);
  assert.equal(w.last(), "beat");
});

test("a second control ends the drive of the first, and begins none", () => {
  const w = page();
  w.down("KeyA");
  w.press(true);
  w.after(0.1);
  w.after(0.1);
  assert.deepEqual(w.sent, ["press", "release"]);
  w.up("KeyA");
  w.press(false);
  w.after(0.1);
  w.press(true);
  w.after(0.1);
  w.down("KeyA");
  w.after(0.1);
  assert.deepEqual(w.sent, ["press", "release", "press", "beat", "release"]);
});

// A held key that repeats after `delay`, every `every` seconds, for so long.
function repeats(w, { delay = 0.5, every = 0.04, seconds }) {
  w.down("KeyA");
  for (let at = delay; at < seconds; at += every) {
    w.now += at === delay ? delay : every;
    w.down("KeyA", { repeat: true });
    w.keys.check(w.now);
    w.hold.heartbeat.last = w.now; // the page ran all the time
  }
}

test("repeats that end without a key-up end the drive within 0.6 s", () => {
  const w = page();
  repeats(w, { seconds: 2 });
  for (let i = 0; i < 5; i += 1) w.after(0.1);
  assert.equal(w.last(), "beat");
  w.after(0.1);
  assert.equal(w.last(), "release");
  assert.deepEqual(w.reasons, ["unseen"]);
});

test("the first repeat is waited for as long as those before took", () => {
  const w = page();
  repeats(w, { delay: 0.5, seconds: 1 });
  w.up("KeyA");
  w.down("KeyA");
  for (let i = 0; i < 14; i += 1) w.after(0.1);
  assert.equal(w.last(), "beat");
  w.after(0.1);
  assert.equal(w.last(), "release");
  w.up("KeyA");
  w.down("KeyA"); // the system may have been told to repeat no more
  for (let i = 0; i < 60; i += 1) w.after(0.1);
  assert.equal(w.last(), "beat");
});

for (const [name, more] of Object.entries({
  "fast": { delay: 0.25, every: 0.02 }, "slow": { delay: 2, every: 0.5 }, "the slowest of Windows": { delay: 2, every: 2 },
})) {
  test(`a key that is held for 30 s drives for 30 s: ${name}`, () => {
    const w = page();
    repeats(w, { ...more, seconds: 30 });
    w.after(0.1);
    assert.equal(w.last(), "beat");
    assert.deepEqual(w.reasons, []);
  });
}

test("without repeats, and after another key went down or up, nothing is missed", () => {
  const w = page();
  w.down("KeyA");
  for (let i = 0; i < 100; i += 1) w.after(0.1);
  assert.equal(w.last(), "beat");
  w.up("KeyA");
  repeats(w, { seconds: 2 });
  w.down("KeyW"); // of two keys only this one repeats
  w.after(0.1);
  w.up("KeyW"); // and now none
  for (let i = 0; i < 100; i += 1) w.after(0.1);
  assert.equal(w.last(), "beat");
});

test("a late repeat lengthens the wait for the next ones", () => {
  const repeated = new KeyRepeats();
  repeated.press(0);
  for (const at of [0.5, 0.54, 0.84, 0.88]) repeated.repeat(at);
  assert.equal(repeated.missing(0.88 + 1.5), false);
  assert.equal(repeated.missing(0.88 + 1.7), true);
});
