// What was asked for, in this language. The journal says it in English; a form that is not known is shown as it came.

import { has, t } from "./i18n.js";

const FORMS = [
  [/^(go to|park at|charge at|load at|unload at) (.+)$/, (verb, name) => [verb, { name }]],
  [/^(move|rotate) (-?[\d.]+) (?:m|rad)$/, (verb, n) => [verb, verb === "move" ? { n } : { n: Math.round((n * 180) / Math.PI) }]],
  [/^(cancel goal|pause goal|resume goal|record bag|end bag) (\S+)$/, (verb, n) => [verb, { n }]],
  [/^(save mark|change mark|delete mark|take over from) (.+)$/, (verb, name) => [verb, { name }]],
  [/^(set the pose) to/, (verb) => [verb, {}]],
  [/^(stop)$/, (verb) => [verb, {}]],
];

export function whatText(what) {
  for (const [form, read] of FORMS) {
    const found = form.exec(what ?? "");
    if (!found) continue;
    const [verb, values] = read(...found.slice(1));
    if (has(`what.${verb}`)) return t(`what.${verb}`, values);
  }
  return what ?? "";
}

// The name of the mark that a goal goes to, null when it goes to none.
export const markOf = (what) => /^(?:go to|park at|charge at|load at|unload at) (.+)$/.exec(what ?? "")?.[1] ?? null;
