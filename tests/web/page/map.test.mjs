import assert from "node:assert/strict";
import { test } from "node:test";

import { MapGestures, headingOf, nearest } from "../../../woosh_pure/web/page/js/map_gestures.js";
import { MAX_SCALE, MIN_SCALE, scaleBar, MapViewport } from "../../../woosh_pure/web/page/js/map_viewport.js";

const near = (a, b) => assert.ok(Math.hypot(a[0] - b[0], a[1] - b[1]) < 1e-6, `${a} is not ${b}`);

function view() {
  const one = new MapViewport();
  one.resize(400, 300);
  return one;
}

test("metres to pixels and back, y upward", () => {
  const v = view();
  near(v.toScreen(0, 0), [200, 150]);
  near(v.toScreen(1, 1), [240, 110]);
  near(v.toWorld(...v.toScreen(3.2, -7.1)), [3.2, -7.1]);
});

test("what is under the finger stays there when zooming and pinching", () => {
  const v = view();
  const before = v.toWorld(333, 44);
  v.zoomAt(333, 44, 2.5);
  near(v.toWorld(333, 44), before);
  const middle = v.toWorld(200, 100);
  v.pinch([150, 100], [250, 100], [130, 160], [330, 160]);
  near(v.toWorld(230, 160), middle);
});

test("zoom has bounds", () => {
  const v = view();
  v.zoomAt(0, 0, 1e9);
  assert.equal(v.scale, MAX_SCALE);
  v.zoomAt(0, 0, 1e-9);
  assert.equal(v.scale, MIN_SCALE);
});

test("the whole map fits beside what covers the canvas", () => {
  const v = view();
  v.fit({ left: -6, right: 6, bottom: -4, top: 4 }, { top: 60 });
  const [x0, y0] = v.toScreen(-6, 4);
  const [x1, y1] = v.toScreen(6, -4);
  assert.ok(x0 >= 15.9 && y0 >= 59.9 && x1 <= 384.1 && y1 <= 284.1);
});

test("the scale bar is a round length of a fitting width", () => {
  for (const scale of [2, 7, 33, 100, 399]) {
    const bar = scaleBar(scale);
    assert.ok(bar.pixels >= 59 && bar.pixels <= 160, `${scale}: ${bar.pixels}`);
    assert.match(bar.metres.toExponential(), /^[125]e/);
    const small = scaleBar(scale, 25);
    assert.ok(small.pixels >= 24.9 && small.pixels <= 66, `${scale}: ${small.pixels}`);
  }
});

function gestures(placing = false) {
  const told = [];
  const note = (name) => (...values) => told.push([name, ...values]);
  const actions = { placing: () => placing };
  for (const name of ["pan", "pinch", "tap", "begin", "drag", "drop", "undo"]) actions[name] = note(name);
  return { g: new MapGestures(actions), told, names: () => told.map(([name]) => name) };
}

test("a short press is a tap, a drag is a move", () => {
  const { g, told, names } = gestures();
  g.down(1, [10, 10], 0);
  g.move(1, [12, 11]);
  g.up(1, [12, 11], 0.2);
  g.down(1, [10, 10], 1);
  g.move(1, [60, 10]);
  g.up(1, [60, 10], 1.2);
  assert.deepEqual(names(), ["tap", "pan"]);
  assert.deepEqual(told[1], ["pan", 50, 0]);
});

test("two fingers pinch, and the lifting of them is no tap", () => {
  const { g, names } = gestures();
  g.down(1, [10, 10], 0);
  g.down(2, [90, 10], 0.1);
  g.move(2, [120, 10]);
  g.up(2, [120, 10], 0.2);
  g.up(1, [10, 10], 0.3);
  assert.deepEqual(names(), ["pinch"]);
});

test("placing: press and drag; a second finger or the system takes it back", () => {
  const { g, names } = gestures(true);
  g.down(1, [10, 10], 0);
  g.move(1, [40, 10]);
  g.up(1, [40, 10], 0.5);
  assert.deepEqual(names(), ["begin", "drag", "drop"]);
  g.down(1, [10, 10], 1);
  g.cancel(1);
  g.down(1, [10, 10], 2);
  g.down(2, [50, 10], 2);
  assert.deepEqual(names().slice(3), ["begin", "undo", "begin", "undo"]);
});

test("the heading is where it was dragged to; a press alone keeps the one of before", () => {
  assert.equal(headingOf(0, 0, 0, 2, 0.3, 1), Math.PI / 2);
  assert.equal(headingOf(0, 0, 0.1, 0.1, 0.3, 1), 1);
});

test("the nearest mark within reach; those without a place are passed over", () => {
  const marks = [{ name: "A", x: 0, y: 0 }, { name: "B", x: 1, y: 0 }, { name: "C", x: null, y: null }];
  assert.equal(nearest(marks, 0.7, 0, 1).name, "B");
  assert.equal(nearest(marks, 5, 5, 1), null);
  assert.equal(nearest(null, 0, 0, 1), null);
});
