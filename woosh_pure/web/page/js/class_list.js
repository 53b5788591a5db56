// The table of a page with several simulated robots: what each of them does, and a button that resets all.

import { button, el, fill } from "./dom.js";
import { pageOf } from "./header.js";
import { number, t, word } from "./i18n.js";
import { Rest } from "./rest.js";
import { attempt } from "./toast.js";

const AGAIN = 2000; // ms between two looks at all robots, one after the other
const BETWEEN = 210; // ms between two resets: the server takes five commands a second

const pause = (ms) => new Promise((then) => setTimeout(then, ms));

export class ClassList {
  constructor({ store, rest }) {
    Object.assign(this, { store, rest, robots: [], box: el("section", { id: "class", class: "card hidden" }) });
    store.on("hello", ({ robots }) => {
      this.robots = (robots ?? []).map((name) => ({ name, page: pageOf(name, robots, location) }));
      this.box.classList.toggle("hidden", this.robots.length < 2);
    });
    store.on("tab hello", () => this.watch());
  }

  to({ page }) {
    return Object.assign(new Rest(new URL(`${page}api/v1/`, location.href).href), { session: this.rest.session });
  }

  async watch() {
    if (this.watching) return;
    this.watching = true;
    while (this.store.get("tab") === "sim" && this.robots.length > 1) {
      for (const robot of this.robots) robot.status = await this.to(robot).json("GET", "status").catch(() => null);
      this.render();
      await pause(AGAIN);
    }
    this.watching = false;
  }

  async reset() {
    for (const robot of this.robots) {
      await attempt(() => this.to(robot).call("POST", "simulator", { do: "reset" }));
      await pause(BETWEEN);
    }
  }

  render() {
    const rows = this.robots.map(({ name, page, status }) => el("tr", {}, el("th", {}, el("a", { href: page }, name)),
      el("td", {}, word("state", status?.activity)), el("td", {}, `${number(status?.battery_percent, 0)} %`)));
    if (!this.button) this.button = button("", () => this.reset(), { id: "class-reset" });
    this.button.textContent = t("sim.resetall");
    fill(this.box, el("table", {}, ...rows), el("div", { class: "row" }, this.button));
  }
}
