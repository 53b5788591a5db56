// The notice above all tabs with the reasons why the robot would not move, if it would not, with a lost localisation (such a
// robot goes to no mark, and still turns or drives by a distance), and with a low battery.

import { button, byId, el, fill, icon } from "./dom.js";
import { changed, onLanguage, t } from "./i18n.js";
import { whoText } from "./command_words.js";
import { hindrances, notLocalised, todoOf, whyOf } from "./reason_words.js";

export class ReadinessNotice {
  constructor({ store, lease }) {
    this.store = store;
    this.lease = lease;
    store.on("readiness lease lost battery", () => this.render());
    onLanguage(() => this.render());
  }

  render() {
    const lease = this.store.get("lease");
    const reasons = hindrances(this.store).map((reason) => [reason, t("ready.notice", { why: whyOf(reason) })]);
    const lost = notLocalised(this.store);
    if (lost) reasons.push([lost, whyOf(lost)]);
    const battery = this.store.get("battery");
    if (battery?.low) reasons.push([{ key: "battery" }, t("why.battery", { n: battery.percent })]);
    const asked = lease?.yours ? lease.asking[0] : null;
    if (!changed(this, reasons, asked)) return;
    fill(byId("notices"), ...reasons.map((each) => this.reason(...each)), asked ? this.asked(asked) : null);
  }

  reason(reason, text) {
    const todo = todoOf(reason);
    return el("div", { class: "notice bad" }, icon("warn"),
      el("div", {}, el("strong", {}, text), todo ? el("p", {}, todo) : null));
  }

  asked(name) {
    return el("div", { class: "notice" }, icon("ask"), el("div", {}, el("strong", {}, t("lease.asked", { name: whoText(name) })),
      el("div", { class: "row" },
        button(t("lease.grant"), () => this.lease.say("grant", name), { kind: "primary" }),
        button(t("lease.deny"), () => this.lease.say("keep", name)))));
  }
}
