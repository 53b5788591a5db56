// The notice above all tabs with the reasons why the robot would not move; shown only if readiness is "no".

import { button, byId, el, fill, icon } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { whoText } from "./command_words.js";
import { blocking, todoOf, whyOf } from "./reason_words.js";

export class ReadinessNotice {
  constructor({ store, lease }) {
    this.store = store;
    this.lease = lease;
    store.on("readiness lease lost", () => this.render());
    onLanguage(() => {
      this.shape = null;
      this.render();
    });
  }

  render() {
    const readiness = this.store.get("lost") === null ? this.store.get("readiness") : null;
    const lease = this.store.get("lease");
    const reasons = readiness?.answer === "no" ? blocking(readiness.reasons) : [];
    const asked = lease?.yours ? lease.askedBy : null;
    const shape = JSON.stringify([reasons, asked]);
    if (shape === this.shape) return;
    this.shape = shape;
    fill(byId("notices"), ...reasons.map((reason) => this.reason(reason)), asked ? this.asked(asked) : null);
  }

  reason(reason) {
    const todo = todoOf(reason);
    return el("div", { class: "notice bad" }, icon("warn"),
      el("div", {}, el("strong", {}, t("ready.notice", { why: whyOf(reason) })),
        todo ? el("p", {}, todo) : null));
  }

  asked(name) {
    return el("div", { class: "notice" }, icon("ask"), el("div", {}, el("strong", {}, t("lease.asked", { name: whoText(name) })),
      el("div", { class: "row" },
        button(t("lease.grant"), () => this.lease.say("grant", name), { kind: "primary" }),
        button(t("lease.deny"), () => this.lease.say("keep")))));
  }
}
