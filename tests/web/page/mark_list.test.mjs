import assert from "node:assert/strict";
import { test } from "node:test";

import { placeLabels } from "../../../woosh_pure/web/page/js/mark_labels.js";
import { found } from "../../../woosh_pure/web/page/js/mark_list.js";

const width = (text) => 8 * text.length;
const boxes = (labels) => labels.map(({ text, x, y }) => {
  const half = width(text) / 2;
  return { left: x - half, right: x + half, top: y - 12, bottom: y + 4 };
});
const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;

test("a name stands below its pin, and beside or above it where another stands", () => {
  const [one] = placeLabels([{ text: "A1", x: 100, y: 100 }], width);
  assert.deepEqual([one.x, one.y], [100, 117]);
  const two = placeLabels([{ text: "A1", x: 100, y: 100 }, { text: "A2", x: 110, y: 100 }], width);
  assert.equal(two.length, 2);
  assert.ok(apart(...boxes(two)));
});

test("no name is written under what covers the map", () => {
  const covered = { left: 60, right: 140, top: 105, bottom: 130 };
  const [label] = boxes(placeLabels([{ text: "A1", x: 100, y: 100 }], width, covered));
  assert.ok(apart(label, covered));
});

test("no name covers another one or a pin, however many there are", () => {
  const pins = Array.from({ length: 67 }, (_, i) => ({ text: `Regal ${i}`, x: 20 + (i * 53) % 380, y: 30 + (i * 31) % 400 }));
  const labels = boxes(placeLabels(pins, width));
  assert.ok(labels.length > 5);
  labels.forEach((a, i) => labels.slice(i + 1).forEach((b) => assert.ok(apart(a, b), JSON.stringify([a, b]))));
  const heads = pins.map(({ x, y }) => ({ left: x - 9, right: x + 9, top: y - 26, bottom: y }));
  for (const label of labels) for (const head of heads) assert.ok(apart(label, head));
});

test("the name of the one that is asked about is there first", () => {
  const pins = Array.from({ length: 30 }, (_, i) => ({ text: `mark ${i}`, x: 100, y: 100, first: i === 29 }));
  assert.equal(placeLabels(pins, width)[0].text, "mark 29");
});

test("a search looks at names and notes, whatever the case", () => {
  const marks = [{ name: "Dock 1", note: "east" }, { name: "仓库", note: null }, { name: "A1" }];
  assert.deepEqual(found(marks, " dock"), [marks[0]]);
  assert.deepEqual(found(marks, "EAST"), [marks[0]]);
  assert.deepEqual(found(marks, "库"), [marks[1]]);
  assert.deepEqual(found(marks, ""), marks);
  assert.deepEqual(found(marks, "null"), []);
});
