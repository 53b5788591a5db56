// Texts for reasons, problems and ends of goals, by the keys of the server's answers, the cause first. Unknown ones are
// shown unchanged: the robot's text, or a sentence of the library.

import { current, has, t } from "./i18n.js";
import { whoText } from "./command_words.js";

const UNSURE = new Set(["unknown", "not_localised", "link_lost", "no_chassis", "silent", "unreachable"]);

// {text, text_zh} in this language.
export const said = (one) => (current() === "zh" ? one?.text_zh || one?.text : one?.text || one?.text_zh) ?? "";

// The text of one reason. A doubtful one, reported before the link broke, may be over.
export function whyOf(reason) {
  const fault = reason.key === "fault" ? reason.values?.words : null;
  const why = fault ? t("why.reported", { fault: said({ text: fault.english, text_zh: fault.chinese }) })
    : has(`why.${reason.key}`) ? t(`why.${reason.key}`) : reason.text;
  return reason.doubt && !UNSURE.has(reason.key) ? `${why} ${t("why.maybe")}` : why;
}

// The advice for a reason; "" if there is none.
export const todoOf = ({ key }) => (has(`todo.${key}`) ? `${t("todo.title")} ${t(`todo.${key}`)}` : "");

const withTodo = (reason) => [whyOf(reason), todoOf(reason)].filter(Boolean).join(" ");

// Each reason once, in the server's order: the cause comes first.
export function distinct(reasons) {
  const shown = new Set();
  return (reasons ?? []).filter((reason) => {
    const why = whyOf(reason);
    return !shown.has(why) && shown.add(why);
  });
}

// The blocking reasons, without a task under way, which is shown as a task.
export const blocking = (reasons) => distinct(reasons?.filter((reason) => reason.blocking && reason.key !== "busy"));

// The reasons for which the robot would not move now; none if that is not known.
export function hindrances(store) {
  const readiness = store.get("lost") === null ? store.get("readiness") : null;
  return readiness?.answer === "no" ? blocking(readiness.reasons) : [];
}

// Why nothing would move the robot now; "" if no reason is known.
export function hindrance(store) {
  if (store.get("lost")) return t("go.lost");
  const [first] = hindrances(store);
  return first ? t("ready.notice", { why: whyOf(first) }) : "";
}

// The reason that tells of a lost localisation, which blocks some motions only; none while it is in doubt.
const unlocalised = (reasons) => reasons?.find((one) => one.key === "not_localised" && !one.blocking && !one.doubt);
export const notLocalised = (store) => unlocalised(store.get("lost") === null ? store.get("readiness")?.reasons : null);

// Why the robot would go to no place now: as `hindrance`, or it does not know where it is.
export function placeHindrance(store) {
  const lost = notLocalised(store);
  return hindrance(store) || (lost ? withTodo(lost) : "");
}

// The first cause with its advice; "" if there is none.
export function causeText(reasons) {
  const [first] = blocking(reasons);
  return first ? withTodo(first) : "";
}

// A refusal of the server, problem+json: its cause, the robot's text, or the text of its kind.
export function refusalText(problem, status) {
  const cause = causeText(problem?.reasons);
  if (cause) return cause;
  const lost = unlocalised(problem?.reasons);
  if (problem?.said) return [t("problem.said", { text: said(problem.said) }), lost ? todoOf(lost) : ""].filter(Boolean).join(" ");
  return kindText(String(problem?.type ?? "").replace("urn:woosh:", ""), { holder: whoText(problem?.holder), detail: problem?.detail })
    || problem?.detail || problem?.title || t("error.status", { status });
}

export const kindText = (kind, values = {}) => (has(`problem.${kind}`) ? t(`problem.${kind}`, values) : "");

// The end of a goal that did not arrive: why, and whether the robot stood still. It stays shown when the cause is over.
export function endText({ kind, reasons, said: own, stands_still: stands }) {
  const moves = stands === false ? t("stop.moves") : "";
  if (kind !== "bad") return moves;
  const why = briefText({ kind, reasons, said: own });
  return [why ? t("task.then", { why }) : "", moves || t(stands ? "task.stood" : "stop.unsure")].filter(Boolean).join(" ");
}

// The same in brief, for the journal.
export const briefText = ({ kind, reasons, said: own }) =>
  kind === "bad" ? (blocking(reasons).map(whyOf)[0] ?? (own ? said(own) : "")) : "";

// The result of a stop, without whether the robot stands still.
export function stopText({ cancelled = [], problems = [], pending = [], looked = false }) {
  const ended = cancelled.length ? "stop.ended" : looked && !problems.length ? "stop.nothing" : null;
  const keys = [ended, problems.length ? "stop.notall" : null, pending.length ? "stop.again" : null];
  return keys.filter(Boolean).map((key) => t(key)).join(" ");
}
