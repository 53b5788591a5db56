// The vendor's warning, which is confirmed before driving by hand.

import { button, el } from "./dom.js";
import { t } from "./i18n.js";

// The warning is part of the panel, not a modal dialog, so that STOP stays in reach.
// Calls answered(true) only when the box was ticked and the switch pressed.
export function warning(answered) {
  const yes = el("button", { type: "submit", class: "danger", disabled: true, id: "warning-yes" }, t("drive.warning.yes"));
  const check = el("input", { type: "checkbox", id: "warning-check", onchange: () => (yes.disabled = !check.checked) });
  return el("form", {
    class: "card", id: "warning", "aria-labelledby": "warning-title", onsubmit: (event) => {
      event.preventDefault();
      answered(check.checked);
    },
  },
  el("h2", { id: "warning-title", tabindex: "-1" }, t("drive.warning.title")),
  el("p", { class: "strong" }, t("drive.warning.1")), el("p", {}, t("drive.warning.2")), el("p", {}, t("drive.warning.3")),
  el("div", { class: "confirmation" },
    el("label", { class: "check" }, check, el("span", {}, t("drive.warning.check"))),
    el("div", { class: "row" }, yes, button(t("go.cancel"), () => answered(false), { kind: "plain" }))));
}
