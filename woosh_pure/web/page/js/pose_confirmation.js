// Whether the robot has accepted a pose, judged by the poses that it reports afterwards.

import { seconds, until } from "./live_connection.js";

const NEAR = 0.3; // m
const NEAR_ANGLE = 0.35; // rad
const PATIENCE = 6; // seconds

const lost = (readiness) => Boolean(readiness?.reasons?.some((reason) => reason.key === "not_localised"));

// {taken, away, turned}: whether the robot reports that pose, and the distance and angle to the reported one. A robot that
// was lost and is localised again has accepted it, too, even at a small distance. Pure.
export function verdict(told, pose, { lostBefore, lostNow }) {
  const away = Math.hypot(pose.x - told.x, pose.y - told.y);
  const turned = Math.abs(Math.atan2(Math.sin(pose.yaw - told.yaw), Math.cos(pose.yaw - told.yaw)));
  const there = away <= NEAR && turned <= NEAR_ANGLE;
  return { taken: !lostNow && (there || lostBefore), away, turned, lost: lostNow };
}

// Wait for the next reported pose; null if none comes. An unchanged pose is not sent again: its age shows a
// new report.
export async function answerOf(store, told, lostBefore) {
  const began = seconds();
  let found = null;
  await until(() => {
    const pose = store.get("pose");
    const age = store.get("ages")?.of("pose", seconds()) ?? Infinity;
    if (pose && seconds() - age > began) found = verdict(told, pose, { lostBefore, lostNow: lost(store.get("readiness")) });
    return found?.taken;
  }, PATIENCE);
  return found;
}

export const isLost = (store) => lost(store.get("readiness"));
