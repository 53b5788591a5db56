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

export const battery = (part) => part && {
  percent: part.percent, charging: part.charging, volts: part.voltage, amps: part.current,
  low: Number.isFinite(part.percent) && part.percent <= 20 && !part.charging,
};

export const readiness = (part) =>
  part && { answer: part.answer === "yes" || part.answer === "no" ? part.answer : "unknown", sentence: part.text, reasons: part.reasons ?? [] };

export const faults = (part) =>
  part && {
    known: part.known,
    list: (part.active ?? []).map((one) => ({
      code: one.code, level: words(one.level), text: one.text, text_zh: one.text_zh, todo: one.todo ?? "",
    })),
  };

// The newest goal that runs, else the newest of all.
export function goal(goals) {
  if (!goals?.length) return null;
  const one = goals.findLast((each) => !each.done) ?? goals[goals.length - 1];
  return {
    id: one.id,
    state: one.state,
    running: !one.done,
    kind: one.done ? kindOf(one.state) : "running",
    key: one.key,
    values: one.values,
    what: one.description,
    left: one.metres_left,
    reasons: one.reasons,
    said: one.said,
    stands: one.stands_still,
    percent: one.percent,
    by: one.who,
    pauses: Boolean(one.can_pause) || one.state === "paused",
  };
}

const RUNNING = new Set(["under way", "paused"]);
const BAD = new Set(["failed", "refused", "rejected", "timed out", "connection lost", "STILL MOVES"]);
const ENDED = new Set(["cancelled", "replaced", "not known", "sent"]); // neither well nor badly

// "running", "ok", "bad" or "ended"
export const kindOf = (state) =>
  RUNNING.has(state) ? "running" : BAD.has(state) ? "bad" : ENDED.has(state) ? "ended" : "ok";

export const entry = (one) => ({
  id: one.id,
  at: one.at,
  by: one.who,
  what: one.what,
  key: one.key,
  values: one.values,
  reasons: one.reasons,
  said: one.said,
  state: one.state,
  kind: kindOf(one.state),
  goal: one.goal ?? "",
});

export const lease = (part) => ({
  holder: part.holder,
  yours: Boolean(part.yours),
  program: Boolean(part.holder_is_program), // it cannot be asked
  seconds: part.seconds,
  askedBy: part.asking?.[0] ?? null,
  asking: part.asking ?? [],
  you: part.you,
});

// {width, height, resolution, origin: [x, y, yaw]}
export function mapFacts(part) {
  const { origin } = part;
  return { ...part, origin: Array.isArray(origin) ? origin : [origin?.x ?? 0, origin?.y ?? 0, origin?.yaw ?? 0] };
}
