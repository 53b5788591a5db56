// The card over the map that asks before a command: text, yes, no. Escape is no. One question at a time.

import { button, byId, el, fill, say, show } from "./dom.js";
import { t } from "./i18n.js";

let ending = () => {};
let checking = () => {};

// ask({text, note, yes, fields, onyes, onno, hindered}): `fields` are elements between the text and the buttons; hindered()
// is why there can be no yes now, or "".
export function ask({ text, note = "", yes, fields = [], onyes, onno = () => {}, hindered = () => "" }) {
  ending();
  const box = byId("confirm");
  const before = document.activeElement;
  const end = (then) => {
    ending = checking = () => {};
    show(box, false);
    fill(box);
    before?.focus?.({ preventScroll: true });
    then();
  };
  ending = () => end(onno);
  const accept = el("button", { type: "submit", class: "primary" }, yes);
  const no = button(t("go.cancel"), () => end(onno), { kind: "plain" });
  const why = el("p", { class: "why", role: "status" });
  checking = () => {
    const reason = hindered();
    say(why, reason);
    show(why, reason !== "");
    accept.disabled = reason !== "";
  };
  fill(
    box,
    el("p", { id: "confirm-text", class: "question" }, text),
    note ? el("p", { class: "quiet" }, note) : null,
    ...fields,
    why,
    el("div", { class: "row" }, accept, no),
  );
  checking();
  box.onsubmit = (event) => {
    event.preventDefault();
    end(onyes);
  };
  box.onkeydown = (event) => {
    if (event.key === "Escape") end(onno);
  };
  show(box);
  (accept.disabled ? no : accept).focus({ preventScroll: true });
}

export const dismiss = () => ending();

// Ask the open question's hindered() again.
export const recheck = () => checking();
