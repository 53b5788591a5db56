import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, CostmapParts } from "../../../woosh_pure/web/page/js/binary_frames.js";
import { Ages, ageWords, isOld, lost, SILENT_SECONDS } from "../../../woosh_pure/web/page/js/freshness.js";
import { take, takeBinary } from "../../../woosh_pure/web/page/js/server_messages.js";
import { TimeSeries, Trail } from "../../../woosh_pure/web/page/js/time_series.js";
import { Store } from "../../../woosh_pure/web/page/js/store.js";
import { fromGamepad, fromKeys, fromStick } from "../../../woosh_pure/web/page/js/steering.js";

function scanFrame(centimetres, { x = 0, y = 0, yaw = 0, min = 0, step = Math.PI / 2 } = {}) {
  const buffer = new ArrayBuffer(24 + 2 * centimetres.length);
  const view = new DataView(buffer);
  view.setUint8(0, 1);
  view.setUint16(2, centimetres.length, true);
  [x, y, yaw, min, step].forEach((value, i) => view.setFloat32(4 + 4 * i, value, true));
  centimetres.forEach((value, i) => view.setUint16(24 + 2 * i, value, true));
  return buffer;
}

test("a scan becomes points in the map; nothing seen gives no point", () => {
  const { kind, points } = decode(scanFrame([100, 0, 65535, 200], { x: 1, y: 2 }));
  assert.equal(kind, "scan");
  assert.equal(points.length, 4);
  [2, 2, 1, 0].forEach((value, i) => assert.ok(Math.abs(points[i] - value) < 1e-5));
});

test("anything cut, odd or of a kind not known gives null", () => {
  const whole = scanFrame([100, 200]);
  for (let size = 0; size < whole.byteLength; size += 1) assert.equal(decode(whole.slice(0, size)), null, `${size} bytes`);
  assert.equal(decode(scanFrame([100], { x: NaN })), null);
  assert.equal(decode(new Uint8Array([9, 1, 2, 3]).buffer), null);
  assert.equal(decode(new Uint8Array([2, 7, 2, 3]).buffer), null);
});

test("a camera frame and a costmap", () => {
  assert.deepEqual(decode(new Uint8Array([2, 1, 0xff, 0xd8]).buffer).source, "depth");
  const buffer = new ArrayBuffer(24 + 6);
  const view = new DataView(buffer);
  view.setUint8(0, 3);
  view.setUint16(2, 3, true);
  view.setUint16(4, 2, true);
  view.setFloat32(8, 0.05, true);
  view.setUint8(24 + 5, 100);
  const frame = decode(buffer);
  assert.deepEqual([frame.width, frame.height, frame.cells[5]], [3, 2, 100]);
  assert.equal(decode(buffer.slice(0, 24)), null, "no row");
  assert.equal(decode(buffer.slice(0, 28)), null, "no whole row");
  view.setUint16(6, 1, true);
  assert.equal(decode(buffer), null, "rows beyond its height");
});

test("a costmap is whole when its last part has come, and only in order", () => {
  const part = (row, rows, value, width = 2, height = 3) => ({ kind: "costmap", width, height, row, rows, cells: new Uint8Array(width * rows).fill(value) });
  const parts = new CostmapParts();
  assert.equal(parts.take(part(0, 2, 7)), null);
  assert.deepEqual([...parts.take(part(2, 1, 9)).cells], [7, 7, 7, 7, 9, 9]);
  assert.equal(parts.take(part(2, 1, 9)), null, "its beginning was lost");
  assert.equal(parts.take(part(0, 2, 7)), null);
  assert.equal(parts.take(part(2, 1, 9, 2, 4)), null, "of another one");
  assert.deepEqual([...parts.take(part(0, 3, 1)).cells], [1, 1, 1, 1, 1, 1], "in one part");
});

test("the state is taken part by part; what is missing stays as it was", () => {
  const [store, ages] = [new Store(), new Ages()];
  const status = { robot_state: "IN_TASK", robot_mode: "AUTOMATIC", task: { id: 7, type: "PICK", state: "RUNNING", destination: "A1" } };
  take(store, ages, { t: "state", status, ages: { battery: 4, velocity: null } }, 50);
  take(store, ages, { t: "state", battery: { percent: 80, charging: true, voltage: 26.1, current: -2 }, ages: {} }, 51);
  assert.equal(store.get("robot").mode, "automatic");
  assert.equal(store.get("robot").task.destination, "A1");
  assert.deepEqual(store.get("battery"), { percent: 80, charging: true, voltage: 26.1, current: -2, low: false });
  assert.equal(ages.of("battery", 51), 5);
  assert.equal(ages.of("velocity", 51), null);
});

test("messages that make no sense change nothing and raise nothing", () => {
  const [store, ages] = [new Store(), new Ages()];
  const odd = [null, 7, {}, { t: "new kind" }, { t: "pose", x: "1" }, { t: "journal" }, { t: "marks" }, { t: "plan", points: 3 }, { t: "state" }];
  for (const message of odd) take(store, ages, message, 1);
  takeBinary(store, ages, new ArrayBuffer(1), 1);
  assert.equal(store.get("pose"), null);
  assert.deepEqual(store.get("plan"), []);
});

test("the journal replaces by number, in order, bounded", () => {
  const [store, ages] = [new Store(), new Ages()];
  const entry = (id, state) => ({ id, at: id, who: "page 1", what: "go to A1", key: "mark", values: { mark: "A1" }, state, text: "", goal: "1" });
  const many = Array.from({ length: 400 }, (_, i) => entry(i + 1, "arrived"));
  take(store, ages, { t: "journal", entries: many }, 1);
  take(store, ages, { t: "journal", entries: [entry(400, "failed"), entry(401, "under way"), entry(402, "cancelled")] }, 1);
  const kept = store.get("journal");
  assert.equal(kept.length, 200);
  assert.deepEqual(kept.slice(-3).map(({ kind }) => kind), ["bad", "running", "ended"]);
});

test("the running goal is shown before one that ended later", () => {
  const [store, ages] = [new Store(), new Ages()];
  const goals = [{ id: "1", done: false, state: "running" }, { id: "2", done: true, state: "rejected" }];
  take(store, ages, { t: "state", goals }, 1);
  assert.equal(store.get("goal").id, "1");
});

test("a silent server is lost before two seconds have passed, and comes before a lost robot", () => {
  assert.ok(SILENT_SECONDS < 1.8);
  const robotLost = { at: 90, text: "gone" };
  assert.equal(lost({ open: true, heardAt: 100, robotLost: null, now: 101 }), null);
  assert.equal(lost({ open: true, heardAt: 100, robotLost: null, now: 101.6 }).who, "server");
  assert.equal(lost({ open: false, heardAt: 100, robotLost, now: 100 }).who, "server");
  assert.equal(lost({ open: true, heardAt: 100, robotLost, now: 100 }).since, 10);
});

test("what is old is old, what was never heard is old, what is sent on change is not", () => {
  assert.equal(isOld("pose", 0.4), false);
  assert.equal(isOld("pose", 2), true);
  assert.equal(isOld("pose", null), true);
  assert.equal(isOld("status", 5000), false);
  assert.deepEqual([0.2, 7, 600, 9000, null].map((age) => ageWords(age).key), ["age.now", "age.seconds", "age.minutes", "age.hours", "age.never"]);
});

test("series and trail are bounded; a gap is no value; a jump begins a new line", () => {
  const series = new TimeSeries(10, 5);
  for (let i = 0; i < 100; i += 1) series.add(i, i % 2 ? NaN : i);
  assert.ok(series.points.length <= 5);
  assert.deepEqual(series.range(), [96, 98]);
  const trail = new Trail(0.05, 1, 50);
  for (let i = 0; i < 500; i += 1) trail.add(0.1 * i, 0);
  assert.ok(trail.count <= 50);
  const lines = trail.lines.length;
  trail.add(900, 0);
  assert.equal(trail.lines.length, lines + 1);
  assert.equal(trail.add(900.01, 0), false);
});

test("a stick that is let go gives zero; a full one gives the limits; left turns left", () => {
  const limits = { vx: 0.4, wz: 0.8 };
  assert.deepEqual(fromStick(0.05, 0.05, limits), { vx: 0, wz: 0 });
  assert.deepEqual(fromStick(0, 1, limits), { vx: 0.4, wz: 0 });
  assert.deepEqual(fromStick(-1, 0, limits), { vx: 0, wz: 0.8 });
  assert.deepEqual(fromStick(NaN, 1, limits), { vx: 0, wz: 0 });
  assert.deepEqual(fromKeys(new Set(["ArrowUp", "KeyA"]), limits), { vx: 0.4, wz: 0.8 });
  assert.deepEqual(fromKeys(new Set(["ArrowUp", "ArrowDown"]), limits), { vx: 0, wz: 0 });
});

test("a gamepad drives only while its shoulder button is held", () => {
  const limits = { vx: 0.4, wz: 0.8 };
  const pad = (pressed) => ({ axes: [0, -1], buttons: [0, 1, 2, 3, 4, 5].map((n) => ({ pressed: pressed === n })) });
  assert.equal(fromGamepad(pad(0), limits), null);
  assert.equal(fromGamepad(undefined, limits), null);
  assert.deepEqual(fromGamepad(pad(5), limits), { vx: 0.4, wz: 0 });
});

test("a listener that fails does not keep the next one from hearing", (context) => {
  context.mock.method(console, "error", () => {});
  const store = new Store();
  const heard = [];
  store.on("a", () => {
    throw new Error("odd");
  });
  store.on("a b", (value) => heard.push(value));
  store.set("a", 1);
  store.set("b", 2);
  assert.deepEqual(heard, [1, 2]);
});
