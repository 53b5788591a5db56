import assert from "node:assert/strict";
import { test } from "node:test";

import { collect } from "../../../woosh_pure/web/page/js/response_body.js";

const stalled = () => new Error("stalled");

// An answer whose body gives these pieces, then ends, or waits for ever.
function answer(pieces, { length = null, ends = true } = {}) {
  const state = { cancelled: false };
  const body = new ReadableStream({
    pull(controller) {
      if (pieces.length) controller.enqueue(new Uint8Array(pieces.shift()));
      else if (ends) controller.close();
      else return new Promise(() => {});
      return undefined;
    },
    cancel() {
      state.cancelled = true;
    },
  });
  const headers = new Headers({ "content-type": "image/png", ...(length === null ? {} : { "content-length": String(length) }) });
  return { body, headers, state };
}

test("all of a body, told how far it is", async () => {
  const told = [];
  const blob = await collect(answer([[1, 2], [3, 4, 5, 6]], { length: 6 }), (...one) => told.push(one), { stalled });
  assert.deepEqual([...new Uint8Array(await blob.arrayBuffer())], [1, 2, 3, 4, 5, 6]);
  assert.equal(blob.type, "image/png");
  assert.deepEqual(told, [[2 / 6, 2, 6], [1, 6, 6]]);
});

test("a body of no told length is taken whole", async () => {
  const blob = await collect(answer([[7]]), () => {}, { stalled });
  assert.equal(blob.size, 1);
});

test("a body that stands still, or is too short, is an error, not a file", async () => {
  const stands = answer([[1]], { length: 9, ends: false });
  await assert.rejects(collect(stands, () => {}, { stalled, seconds: 0.05 }), /stalled/);
  assert.ok(stands.state.cancelled);
  await assert.rejects(collect(answer([[1]], { length: 9 }), () => {}, { stalled }), /stalled/);
});

test("it can be broken off", async () => {
  const ending = new AbortController();
  const endless = answer([[1], [2]], { length: 9, ends: false });
  const work = collect(endless, () => ending.abort(), { stalled, seconds: 5, signal: ending.signal });
  await assert.rejects(work, /aborted/);
  assert.ok(endless.state.cancelled);
});
