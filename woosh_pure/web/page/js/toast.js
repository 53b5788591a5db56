// Short messages that disappear by themselves; errors stay longer.

import { byId, el, icon } from "./dom.js";

const SECONDS = { ok: 4, wait: 4, ask: 9, bad: 9 };
const ICONS = { ok: "ok", wait: "wait", ask: "ask", bad: "warn" };
const MAX_TOASTS = 3;

export function toast(text, kind = "ok") { // returns the message, which may be removed before
  const box = byId("toasts");
  const note = el("div", { class: `toast ${kind}` }, icon(ICONS[kind]), el("span", {}, text));
  note.onclick = () => note.remove();
  box.prepend(note); // a small map cuts off the oldest
  while (box.children.length > MAX_TOASTS) box.lastChild.remove();
  setTimeout(() => note.remove(), SECONDS[kind] * 1000);
  return note;
}

// Run `work`, and show the error if the server refuses; null then.
export async function attempt(work) {
  try {
    return await work();
  } catch (error) {
    toast(error.message, error.problem?.kind ?? "bad"); // a request for control is not an error
    return null;
  }
}
