// The dialog for the token, open until it is accepted; shows why a token was refused.

import { byId, el, fill, say } from "./dom.js";
import { t } from "./i18n.js";

export class TokenDialog {
  // accepted() when a token was accepted
  constructor(rest, accepted) {
    this.rest = rest;
    this.accepted = accepted;
    this.refusal = null; // why the token in the address was refused
    this.dialog = byId("token");
    this.dialog.oncancel = (event) => event.preventDefault(); // the page is empty without a token
  }

  get open() {
    return this.dialog.open;
  }

  ask() {
    if (this.open) return;
    this.why = el("p", { class: "why", role: "alert" }, this.refusal);
    this.input = el("input", {
      type: "password", autocomplete: "current-password", autocapitalize: "off", spellcheck: "false", required: true, id: "token-input",
    });
    const shown = el("input", {
      type: "checkbox", id: "token-shown", onchange: () => (this.input.type = shown.checked ? "text" : "password"),
    });
    this.use = el("button", { class: "primary", id: "token-use" }, t("token.use"));
    fill(this.dialog, el("form", { onsubmit: (event) => this.submit(event) },
      el("h2", { id: "token-title" }, t("token.title")), el("p", {}, t("token.text")),
      el("label", {}, el("span", {}, t("token.label")), this.input), this.why,
      el("label", { class: "check" }, shown, el("span", {}, t("token.show"))),
      el("div", { class: "row" }, this.use)));
    this.dialog.showModal();
    this.input.focus();
  }

  async submit(event) {
    event.preventDefault();
    this.use.disabled = true;
    say(this.why, "");
    const refusal = await this.rest.login(this.input.value.trim());
    this.use.disabled = false;
    if (refusal !== null) {
      say(this.why, refusal);
      this.input.select();
      return;
    }
    this.refusal = null;
    this.dialog.close();
    this.accepted();
  }
}
