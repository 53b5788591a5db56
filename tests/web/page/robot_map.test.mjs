import assert from "node:assert/strict";
import { test } from "node:test";

import { choices, drawZones } from "../../../woosh_pure/web/page/js/robot_map.js";

test("every map of every scene can be chosen, and a robot that names none has no choice", () => {
  const scenes = [{ name: "hall", maps: ["ground", "upper"] }, { name: "yard", maps: ["yard"] }];
  assert.deepEqual(choices({ scenes }), [["hall", "ground"], ["hall", "upper"], ["yard", "yard"]]);
  assert.deepEqual(choices({ scenes: [] }), []);
  assert.deepEqual(choices(undefined), []);
});

test("a zone is drawn where it is, and its speed limit is written in its middle", () => {
  const told = [];
  const note = (name) => (...values) => told.push([name, ...values]);
  const context = Object.fromEntries(
    ["beginPath", "lineTo", "closePath", "fill", "stroke", "setLineDash", "fillText"].map((name) => [name, note(name)]),
  );
  const view = { toScreen: (x, y) => [10 * x, -10 * y] };
  const points = [[0, 0], [2, 0], [2, 2], [0, 2]];
  drawZones(context, view, {}, [{ points, max_speed: 0.3 }, { points, max_speed: null }]);
  assert.deepEqual(told.filter(([name]) => name === "fillText"), [["fillText", "0.3 m/s", 10, -10]]);
  assert.equal(told.filter(([name]) => name === "lineTo").length, 8);
  drawZones(context, view, {}, undefined);
});
