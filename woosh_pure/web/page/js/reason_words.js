// Why something did not work, in words: the cause first, by the keys of the server's answers. What has no words here
// is said as it came: a robot's own words, or a sentence of the library.

import { current, has, t } from "./i18n.js";
import { whoText } from "./command_words.js";

const UNSURE = new Set(["unknown", "not_localised", "link_lost", "no_chassis", "silent", "unreachable"]);

// {text, text_zh} in this language.
const said = (one) => (current() === "zh" ? one.text_zh || one.text : one.text || one.text_zh) ?? "";

// The words of one reason; of a doubt about what was told before, that it may be over.
export function whyOf(reason) {
  const fault = reason.key === "fault" ? reason.values?.words : null;
  const why = fault ? t("why.told", { fault: said({ text: fault.english, text_zh: fault.chinese }) })
    : has(`why.${reason.key}`) ? t(`why.${reason.key}`) : reason.text;
  return reason.doubt && !UNSURE.has(reason.key) ? `${why} ${t("why.maybe")}` : why;
}

// What to do about it: "" where that is not known.
export const todoOf = ({ key }) => (has(`todo.${key}`) ? `${t("todo.title")} ${t(`todo.${key}`)}` : "");

// Each once, in the server's order: the cause comes first.
export function distinct(reasons) {
  const told = new Set();
  return (reasons ?? []).filter((reason) => {
    const why = whyOf(reason);
    return !told.has(why) && told.add(why);
  });
}

// What blocks. A task under way does not count: it is shown as a task.
export const blocking = (reasons) => distinct(reasons?.filter((reason) => reason.blocking && reason.key !== "busy"));

// The first cause and what to do about it; "" without one.
export function causeText(reasons) {
  const [first] = blocking(reasons);
  return first ? [whyOf(first), todoOf(first)].filter(Boolean).join(" ") : "";
}

// A refusal of the server, problem+json: its cause, the robot's own words, or what its kind says.
export function refusalText(problem, status) {
  const cause = causeText(problem?.reasons);
  if (cause) return cause;
  if (problem?.said) return t("problem.said", { text: said(problem.said) });
  return kindText(String(problem?.type ?? "").replace("urn:woosh:", ""), { holder: whoText(problem?.holder) })
    || problem?.detail || problem?.title || t("error.status", { status });
}

export const kindText = (kind, values = {}) => (has(`problem.${kind}`) ? t(`problem.${kind}`, values) : "");

// How a goal ended that did not arrive: why, and whether the robot stands still.
export function endText({ kind, reasons, said: own, stands }) {
  const moves = stands === false ? t("stop.moves") : "";
  if (kind !== "bad") return moves;
  const why = causeText(reasons) || (own ? said(own) : "");
  return [why, moves || t(stands ? "stop.stands" : "stop.unsure")].filter(Boolean).join(" ");
}

// The same for the list of what was done, in brief.
export const briefText = ({ kind, reasons, said: own }) =>
  kind === "bad" ? (blocking(reasons).map(whyOf)[0] ?? (own ? said(own) : "")) : "";

// What a stop has done, besides whether the robot stands still.
export function stopText({ cancelled = [], problems = [], pending = [], looked = false }) {
  const ended = cancelled.length ? "stop.ended" : looked && !problems.length ? "stop.nothing" : null;
  const keys = [ended, problems.length ? "stop.notall" : null, pending.length ? "stop.again" : null];
  return keys.filter(Boolean).map((key) => t(key)).join(" ");
}
