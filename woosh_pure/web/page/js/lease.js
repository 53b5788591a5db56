// The lease, called control on the page: requested, shown, granted and given back. A page that holds it must agree; a
// second request takes it from a program.

import { ask } from "./confirm.js";
import { button, el, fill } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { Refused } from "./rest.js";
import { until } from "./live_connection.js";
import { attempt, toast } from "./toast.js";
import { whoText } from "./command_words.js";

const MAX_WAIT_SECONDS = 3; // seconds to wait for a free lease

export class Lease {
  constructor({ store, link, rest, box }) {
    Object.assign(this, { store, link, rest, box }); // the box shows it
    this.asked = false; // this page's request, not answered yet
    store.on("lease", (lease) => {
      const asked = this.asked;
      this.asked = lease.asking.includes(lease.you);
      if (asked && lease.yours) toast(t("lease.yours"));
      else if (asked && !this.asked && this.held) toast(t("lease.kept", { name: this.holder }), "ask");
      this.render();
    });
    // A closed page gives control back, so that others need not wait for its expiry.
    addEventListener("pagehide", () => this.yours && this.say("give"));
    store.on("link", () => {
      this.asked = false;
      this.render();
    });
    onLanguage(() => this.render());
  }

  get yours() {
    return Boolean(this.store.get("lease")?.yours);
  }

  // "ask", "give", "grant" to a client, or "keep", which refuses its request
  say(op, to) {
    this.link.send({ t: "lease", op, to });
  }

  // Before a motion: take control if it is free, else request it and show that.
  async need() {
    const lease = this.store.get("lease");
    if (lease === null || lease.yours) return;
    this.say("ask");
    await until(() => this.yours || this.held, MAX_WAIT_SECONDS);
    if (!this.yours && this.held && this.store.get("lease").holder_is_program) await this.takeOver();
    if (this.yours) return;
    throw this.held ? new Refused(t("lease.waiting", { name: this.holder }), 0, { kind: "ask" }) : new Refused(t("drive.needlease"));
  }

  // Asks whether to take over from a program; ends when control was obtained or refused.
  takeOver() {
    return new Promise((done) => {
      const take = async () => {
        const lease = await attempt(() => this.rest.json("POST", "lease", { take_over: true }));
        await until(() => !lease?.yours || this.yours, MAX_WAIT_SECONDS);
        done();
      };
      ask({
        text: t("lease.takeoverask", { name: this.holder }), note: t("lease.takeovernote"), yes: t("lease.takeover"),
        onyes: take, onno: done,
      });
    });
  }

  get held() {
    const lease = this.store.get("lease");
    return Boolean(lease?.holder) && !lease.yours;
  }

  get holder() {
    return whoText(this.store.get("lease")?.holder);
  }

  get otherText() {
    return t("lease.other", { name: this.holder });
  }

  render() {
    const lease = this.store.get("lease");
    fill(this.box, ...(lease ? this.parts(lease) : []));
  }

  parts(lease) {
    const parts = [];
    if (lease.yours) {
      parts.push(el("p", {}, t("lease.yours")));
      if (!lease.asking.length) parts.push(button(t("lease.give"), () => this.say("give"), { kind: "plain" }));
    } else if (this.held) {
      parts.push(el("p", {}, this.otherText));
      if (this.asked && lease.holder_is_program) {
        parts.push(el("p", { class: "quiet" }, t("lease.program", { name: this.holder })));
        parts.push(button(t("lease.takeover"), () => this.takeOver(), { id: "take-over" }));
      } else if (this.asked) parts.push(el("p", { class: "quiet" }, t("lease.waiting", { name: this.holder })));
      else parts.push(button(t("lease.ask"), () => this.say("ask"), { class: "ask" }));
    } else {
      parts.push(el("p", {}, t("lease.free")));
      parts.push(button(t("lease.take"), () => this.say("ask")));
    }
    return parts;
  }
}
