import assert from "node:assert/strict";
import { test } from "node:test";

import { BUFFER_LIMIT, GAP_SECONDS, Heart } from "../../../woosh_pure/web/page/js/heartbeat.js";

function heart() {
  const world = { now: 100, sent: [], waiting: 0 };
  world.heart = new Heart({ send: (m) => world.sent.push(m), now: () => world.now, buffered: () => world.waiting });
  world.after = (seconds) => {
    world.now += seconds;
    world.heart.tick();
  };
  world.kinds = () => world.sent.map((message) => message.t);
  return world;
}

test("nothing is sent before a press", () => {
  const w = heart();
  for (let i = 0; i < 20; i += 1) w.after(0.1);
  assert.deepEqual(w.sent, []);
});

test("a press, a beat for each tick while held, and nothing after the release", () => {
  const w = heart();
  assert.equal(w.heart.press(0.2, 0.1), true);
  w.after(0.1);
  w.heart.steer(0.1, -0.3);
  w.after(0.1);
  w.heart.release();
  w.after(0.1);
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat", "beat", "release"]);
  assert.deepEqual(w.sent.slice(0, 3).map(({ seq }) => seq), [1, 2, 3]);
  assert.deepEqual([w.sent[1].vx, w.sent[2].vx, w.sent[2].wz], [0.2, 0.1, -0.3]);
  assert.ok(Math.abs(w.sent[2].at - 100.2) < 1e-9);
});

test("a page that did not run ends the drive, and never resumes while it is still held", () => {
  const w = heart();
  w.heart.press(0.2, 0);
  w.after(0.1);
  w.after(GAP_SECONDS + 0.01);
  for (let i = 0; i < 10; i += 1) w.after(0.1);
  w.heart.steer(0.3, 0);
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat", "release"]);
  assert.equal(w.heart.state, "over");
  assert.equal(w.heart.press(0.2, 0), false, "still held: no new press");
  w.heart.release();
  assert.equal(w.heart.press(0.2, 0), true, "let go, then pressed again");
});

for (const why of ["hidden", "blur", "taken", "lost", "stopped", "unleased"]) {
  test(`${why}: one release, then silence until everything was let go`, () => {
    const w = heart();
    w.heart.press(0.2, 0);
    w.heart.end(why);
    w.after(0.1);
    w.after(0.1);
    assert.deepEqual(w.kinds(), ["press", "release"]);
    assert.equal(w.heart.reason, why);
    assert.equal(w.heart.press(0.2, 0), false);
  });
}

test("what the server has ended is over here, too", () => {
  const w = heart();
  w.heart.press(0.2, 0);
  w.heart.ended("late");
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press"]);
  assert.equal(w.heart.state, "over");
});

test("an end before any press changes nothing", () => {
  const w = heart();
  w.heart.end("hidden");
  w.heart.ended("late");
  w.heart.release();
  assert.deepEqual([w.heart.state, w.sent], ["idle", []]);
});

test("a beat is skipped while others wait in the buffer, and none is made up for later", () => {
  const w = heart();
  w.heart.press(0.2, 0);
  w.waiting = BUFFER_LIMIT + 1;
  for (let i = 0; i < 3; i += 1) w.after(0.1);
  w.waiting = 0;
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat"]);
  assert.equal(w.heart.skipped, 3);
});
