// Converts the parts of the server's messages to the values that the page shows. Pure; a missing value stays null.

const words = (name) => (typeof name === "string" ? name.toLowerCase().replaceAll("_", " ") : null);

export function robot(status) {
  if (!status) return null;
  const { task } = status;
  return {
    mode: words(status.robot_mode),
    task: task?.id ? { type: words(task.type), state: words(task.state), destination: task.destination || "" } : null,
  };
}

export const battery = (part) =>
  part && { ...part, low: Number.isFinite(part.percent) && part.percent <= 20 && !part.charging };

// The newest goal that runs, else the newest of all.
export function goal(goals) {
  if (!goals?.length) return null;
  const one = goals.findLast((each) => !each.done) ?? goals[goals.length - 1];
  return {
    ...one, what: one.description, running: !one.done, kind: one.done ? kindOf(one.state) : "running",
    pauses: Boolean(one.can_pause) || one.state === "paused",
  };
}

const RUNNING = new Set(["under way", "paused"]);
const BAD = new Set(["failed", "refused", "rejected", "timed out", "connection lost", "STILL MOVES"]);
const ENDED = new Set(["cancelled", "replaced", "not known", "sent", "stopped", "interrupted"]); // neither well nor badly

// "running", "ok", "bad" or "ended"
export const kindOf = (state) =>
  RUNNING.has(state) ? "running" : BAD.has(state) ? "bad" : ENDED.has(state) ? "ended" : "ok";

// {width, height, resolution, origin: [x, y, yaw]}
export const mapFacts = ({ origin, ...part }) => ({ ...part, origin: [origin?.x ?? 0, origin?.y ?? 0, origin?.yaw ?? 0] });
