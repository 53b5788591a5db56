import assert from "node:assert/strict";
import { test } from "node:test";

import { BUFFER_LIMIT, GAP_SECONDS, Heartbeat } from "../../../woosh_pure/web/page/js/heartbeat.js";

function heartbeat() {
  const world = { now: 100, sent: [], waiting: 0 };
  world.heartbeat = new Heartbeat({ send: (m) => world.sent.push(m), now: () => world.now, buffered: () => world.waiting });
  world.after = (seconds) => {
    world.now += seconds;
    world.heartbeat.tick();
  };
  world.kinds = () => world.sent.map((message) => message.t);
  return world;
}

test("nothing is sent before a press", () => {
  const w = heartbeat();
  for (let i = 0; i < 20; i += 1) w.after(0.1);
  assert.deepEqual(w.sent, []);
});

test("a press, a beat for each tick while held, and nothing after the release", () => {
  const w = heartbeat();
  assert.equal(w.heartbeat.press(0.2, 0.1), true);
  w.after(0.1);
  w.heartbeat.steer(0.1, -0.3);
  w.after(0.1);
  w.heartbeat.release();
  w.after(0.1);
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat", "beat", "release"]);
  assert.deepEqual(w.sent.slice(0, 3).map(({ seq }) => seq), [1, 2, 3]);
  assert.deepEqual([w.sent[1].vx, w.sent[2].vx, w.sent[2].wz], [0.2, 0.1, -0.3]);
  assert.ok(Math.abs(w.sent[2].at - 100.2) < 1e-9);
});

test("a page that did not run ends the drive, and never resumes while it is still held", () => {
  const w = heartbeat();
  w.heartbeat.press(0.2, 0);
  w.after(0.1);
  w.after(GAP_SECONDS + 0.01);
  for (let i = 0; i < 10; i += 1) w.after(0.1);
  w.heartbeat.steer(0.3, 0);
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat", "release"]);
  assert.equal(w.heartbeat.state, "over");
  assert.equal(w.heartbeat.press(0.2, 0), false, "still held: no new press");
  w.heartbeat.release();
  assert.equal(w.heartbeat.press(0.2, 0), true, "let go, then pressed again");
});

for (const why of ["hidden", "blur", "taken", "lost", "stopped", "unleased"]) {
  test(`${why}: one release, then silence until everything was let go`, () => {
    const w = heartbeat();
    w.heartbeat.press(0.2, 0);
    w.heartbeat.end(why);
    w.after(0.1);
    w.after(0.1);
    assert.deepEqual(w.kinds(), ["press", "release"]);
    assert.equal(w.heartbeat.reason, why);
    assert.equal(w.heartbeat.press(0.2, 0), false);
  });
}

test("what the server has ended is over here, too", () => {
  const w = heartbeat();
  w.heartbeat.press(0.2, 0);
  w.heartbeat.ended("late");
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press"]);
  assert.equal(w.heartbeat.state, "over");
});

test("an end before any press changes nothing", () => {
  const w = heartbeat();
  w.heartbeat.end("hidden");
  w.heartbeat.ended("late");
  w.heartbeat.release();
  assert.deepEqual([w.heartbeat.state, w.sent], ["idle", []]);
});

test("a beat is skipped while others wait in the buffer, and none is made up for later", () => {
  const w = heartbeat();
  w.heartbeat.press(0.2, 0);
  w.waiting = BUFFER_LIMIT + 1;
  for (let i = 0; i < 3; i += 1) w.after(0.1);
  w.waiting = 0;
  w.after(0.1);
  assert.deepEqual(w.kinds(), ["press", "beat"]);
  assert.equal(w.heartbeat.skipped, 3);
});
