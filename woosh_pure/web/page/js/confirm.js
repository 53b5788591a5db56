// The card over the map that asks before a command: text, yes, no. Escape is no. One question at a time.

import { button, byId, el, fill, show } from "./dom.js";
import { t } from "./i18n.js";

const form = () => byId("confirm");
let ending = () => {};

// ask({text, note, yes, fields, onyes, onno}): `fields` are elements between the text and the buttons.
export function ask({ text, note = "", yes, fields = [], onyes, onno = () => {} }) {
  ending();
  const box = form();
  const before = document.activeElement;
  const end = (then) => {
    ending = () => {};
    show(box, false);
    fill(box);
    before?.focus?.({ preventScroll: true });
    then();
  };
  ending = () => end(onno);
  const accept = el("button", { type: "submit", class: "primary" }, yes);
  fill(
    box,
    el("p", { id: "confirm-text", class: "question" }, text),
    note ? el("p", { class: "quiet" }, note) : null,
    ...fields,
    el("div", { class: "row" }, accept, button(t("go.cancel"), () => end(onno), { kind: "plain" })),
  );
  box.onsubmit = (event) => {
    event.preventDefault();
    end(onyes);
  };
  box.onkeydown = (event) => {
    if (event.key === "Escape") end(onno);
  };
  show(box);
  accept.focus({ preventScroll: true });
}

export const dismiss = () => ending();
