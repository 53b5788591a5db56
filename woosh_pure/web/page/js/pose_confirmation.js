// What the robot says to a pose that it was told: nothing counts but what it tells after that.

import { seconds } from "./live_connection.js";

const NEAR = 0.3; // m
const NEAR_ANGLE = 0.35; // rad
const PATIENCE = 6; // seconds

const lost = (readiness) => Boolean(readiness?.reasons?.some((reason) => reason.key === "not_localised"));

// Pure. {taken, away, turned}: whether the robot is there by its own word, and how far from there it says it is.
// Found again is taken, too: it may have found itself a little beside what it was told.
export function verdict(told, pose, { lostBefore, lostNow }) {
  const away = Math.hypot(pose.x - told.x, pose.y - told.y);
  const turned = Math.abs(Math.atan2(Math.sin(pose.yaw - told.yaw), Math.cos(pose.yaw - told.yaw)));
  const there = away <= NEAR && turned <= NEAR_ANGLE;
  return { taken: !lostNow && (there || lostBefore), away, turned, lost: lostNow };
}

// Wait for its word; null when it says nothing more about where it is. A pose that has not changed is not sent again:
// how old it is tells that the robot has said it once more.
export async function answerOf(store, told, lostBefore) {
  const began = seconds();
  let found = null;
  while (!found?.taken && seconds() < began + PATIENCE) {
    await new Promise((done) => setTimeout(done, 100));
    const pose = store.get("pose");
    const age = store.get("ages")?.of("pose", seconds()) ?? Infinity;
    if (pose && seconds() - age > began) found = verdict(told, pose, { lostBefore, lostNow: lost(store.get("readiness")) });
  }
  return found;
}

export const isLost = (store) => lost(store.get("readiness"));
