// Puts the messages of the live connection into the store. `now` is seconds of this page's clock.

import { decode } from "./binary_frames.js";
import * as shapes from "./server_values.js";

// Part of the state -> its name here, and its converter. The others are taken as they come.
const PARTS = { status: ["robot", shapes.robot], battery: ["battery", shapes.battery], goals: ["goal", shapes.goal] };
const SAME = ["activity", "readiness", "faults", "velocity", "odometer", "rates", "recordings", "missions"];
const MAX_ENTRIES = 200;
const list = (value) => (Array.isArray(value) ? value : []);

const KINDS = {
  // The journal is sent again after each hello: a restarted server counts from one.
  hello(store, message) {
    store.set("journal", []);
    store.set("hello", message);
  },
  plan: (store, message) => store.set("plan", list(message.points)),
  obstacles: (store, message) => store.set("obstacles", list(message.circles)),
  marks: (store, message) => store.set("marks", list(message.marks)),
  site: (store, message) => store.set("site", { ...message, scenes: list(message.scenes), zones: list(message.zones) }),
  map: (store, message) => store.set("map", shapes.mapFacts(message)),
  lease: (store, message) => store.set("lease", message),
  drive: (store, message) => store.set("drive", message),
  stop: (store, message) => store.set("stop", message),
  journal,
  state,
  pose(store, message, ages, now) {
    if (![message.x, message.y, message.yaw].every(Number.isFinite)) return;
    ages.take("pose", message.age ?? 0, now);
    store.set("pose", { x: message.x, y: message.y, yaw: message.yaw });
  },
  lost(store, message, ages, now) {
    store.set("robotlost", message.text ? { text: message.text, at: now - (message.since ?? 0), key: message.key } : null);
  },
};

// An unknown kind is ignored: a newer server may have more.
export const take = (store, ages, message, now) => KINDS[message?.t]?.(store, message, ages, now);

function state(store, message, ages, now) {
  for (const [feed, age] of Object.entries(message.ages ?? {})) ages.take(feed, age, now);
  for (const [part, [name, read]] of Object.entries(PARTS)) {
    if (part in message) store.set(name, read(message[part]));
  }
  for (const part of SAME) if (part in message) store.set(part, message[part]);
  store.set("ages", ages);
}

function journal(store, message) {
  const entries = new Map((store.get("journal") ?? []).map((entry) => [entry.id, entry]));
  for (const one of list(message.entries)) entries.set(one.id, { ...one, kind: shapes.kindOf(one.state) });
  store.set("journal", [...entries.values()].sort((a, b) => a.id - b.id).slice(-MAX_ENTRIES));
}

export function takeBinary(store, ages, buffer, now, parts) {
  let frame = decode(buffer);
  if (frame?.kind === "costmap") frame = parts.take(frame);
  if (frame === null) return;
  if (frame.kind === "scan") ages.take("scan", 0, now);
  store.set(frame.kind, frame);
}
