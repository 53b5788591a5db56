// The age of each feed, whether it is shown as old, and whether server or robot is lost. Pure; seconds of this page's clock.

// Feeds that are sent continuously. One that is sent on change only ("status") never counts as old.
export const LIMITS = { pose: 1.5, velocity: 1.5, scan: 2, battery: 20 };
export const SILENT_SECONDS = 1.2; // the server sends at least once a second

export function isOld(feed, age) {
  if (age === null || age === undefined) return true;
  return age > (LIMITS[feed] ?? Infinity);
}

// {key, values} of the dictionary: "now", "3 s ago", "4 min ago".
export function ageWords(age) {
  if (age === null || age === undefined || !Number.isFinite(age)) return { key: "age.never", values: {} };
  if (age < 1.5) return { key: "age.now", values: {} };
  if (age < 100) return { key: "age.seconds", values: { n: Math.round(age) } };
  if (age < 5400) return { key: "age.minutes", values: { n: Math.round(age / 60) } };
  return { key: "age.hours", values: { n: Math.round(age / 3600) } };
}

// The receive time of each feed by this page's clock: the age from the server, and the time of that report.
export class Ages {
  constructor() {
    this.heard = new Map();
  }

  take(feed, age, now) {
    if (Number.isFinite(age)) this.heard.set(feed, now - Math.max(0, age));
    else this.heard.delete(feed);
  }

  of(feed, now) {
    const at = this.heard.get(feed);
    return at === undefined ? null : Math.max(0, now - at);
  }
}

// What is lost: null, or {who: "server" | "robot" | "absent", since: seconds, text}. A lost server comes
// first: without it the robot's state is unknown.
export function lost({ open, heardAt, robotLost, now }) {
  const silent = heardAt === null ? 0 : now - heardAt;
  if (!open || silent > SILENT_SECONDS) return { who: "server", since: silent, text: "" };
  if (robotLost) return { who: robotLost.key === "not-connected" ? "absent" : "robot", since: now - robotLost.at, text: robotLost.text };
  return null;
}
