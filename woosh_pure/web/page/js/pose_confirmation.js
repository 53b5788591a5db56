// Whether the robot has accepted a pose, judged by the poses that it reports afterwards.

import { seconds, until } from "./live_connection.js";

const NEAR_METRES = 0.3; // m
const NEAR_RADIANS = 0.35; // rad
const MAX_WAIT_SECONDS = 6; // seconds

const lost = (readiness) => Boolean(readiness?.reasons?.some((reason) => reason.key === "not_localised"));

// {taken, away, turned}: whether the robot reports that pose, and the distance and angle to the reported one. A robot that
// was lost and is localised again has accepted it, too, even at a small distance. Pure.
export function verdict(given, pose, { lostBefore, lostNow }) {
  const away = Math.hypot(pose.x - given.x, pose.y - given.y);
  const turned = Math.abs(Math.atan2(Math.sin(pose.yaw - given.yaw), Math.cos(pose.yaw - given.yaw)));
  const there = away <= NEAR_METRES && turned <= NEAR_RADIANS;
  return { taken: !lostNow && (there || lostBefore), away, turned, lost: lostNow };
}

// Wait for the next reported pose; null if none comes. An unchanged pose is not sent again: its age shows a
// new report.
export async function answerOf(store, given, lostBefore) {
  const began = seconds();
  let found = null;
  await until(() => {
    const pose = store.get("pose");
    const age = store.get("ages")?.of("pose", seconds()) ?? Infinity;
    if (pose && seconds() - age > began) found = verdict(given, pose, { lostBefore, lostNow: lost(store.get("readiness")) });
    return found?.taken;
  }, MAX_WAIT_SECONDS);
  return found;
}

export const isLost = (store) => lost(store.get("readiness"));
