// Texts for commands and client names, in the page's language. Unknown ones are shown unchanged.

import { has, inDegrees, number, t } from "./i18n.js";

const whole = (radians) => number(inDegrees(radians), 0);
const two = (metres) => number(metres, 2);
const SHOWN = { angle: whole, yaw: whole, distance: two, x: two, y: two, holder: whoText };

// A command {key, values, what} of a goal or an entry of the journal; values in m and rad.
export function whatText({ key, values, what }) {
  if (!has(`what.${key}`)) return what ?? "";
  const shown = Object.entries(values ?? {}).map(([name, value]) => [name, SHOWN[name]?.(value) ?? value]);
  return t(`what.${key}`, Object.fromEntries(shown));
}

const WHO = [[/^page (?<n>\d+) at (?<address>.+)$/, "who.page"], [/^program at (?<address>.+)$/, "who.program"]];

// A client's name, translated if the server assigned it.
export function whoText(name) {
  for (const [form, key] of WHO) {
    const found = form.exec(name ?? "");
    if (found) return t(key, found.groups);
  }
  return name ?? "";
}
