// The header: robot, state, battery, faults and language; and the banner over the map when a connection is lost.

import { byId, el, fill, icon, say, show } from "./dom.js";
import { isOld, lost } from "./freshness.js";
import { changed, current, onLanguage, relabel, t, use, word } from "./i18n.js";
import { seconds } from "./live_connection.js";
import { keep } from "./storage.js";

export class Header {
  constructor({ store, ages, link, tabs }) {
    Object.assign(this, { store, ages, link });
    store.on("hello", (hello) => this.hello(hello));
    store.on("battery activity faults ages link", () => this.render());
    byId("fault-chip").onclick = () => tabs.choose("health");
    byId("language").onclick = () => {
      use(current() === "en" ? "zh" : "en");
      keep("woosh-language", current());
    };
    onLanguage(() => {
      document.documentElement.lang = current();
      const [name, short, lang] = current() === "en" ? ["中文", "中文", "zh"] : ["English", "EN", "en"];
      fill(byId("language"), el("span", { class: "wide" }, name), el("span", { class: "narrow" }, short));
      byId("language").lang = lang;
      relabel();
      this.render();
    });
    setInterval(() => this.tick(), 100);
  }

  hello(hello) {
    say(byId("robot-name"), hello.robot ?? "Woosh");
    document.title = hello.robot ?? "Woosh";
    show(byId("simulated"), Boolean(hello.simulator));
    const robots = hello.robots ?? [];
    show(byId("robots"), robots.length > 1);
    byId("robot-name").classList.toggle("unseen", robots.length > 1); // the list shows its name
    if (robots.length < 2) return;
    const select = byId("robots").querySelector("select");
    fill(select, ...robots.map((name) => el("option", { value: name, selected: name === hello.robot }, name)));
    select.onchange = () => {
      location.assign(pageOf(select.value, robots, location));
    };
  }

  render() {
    const { store } = this;
    say(byId("state"), stateText(store) ?? t(store.get("link") === "open" ? "state.undefined" : "top.connecting"));
    this.battery();
    const n = store.get("faults")?.active.length ?? 0;
    const chip = byId("fault-chip");
    show(chip, n > 0);
    chip.setAttribute("aria-label", t("top.faults", { n }));
    fill(chip, icon("warn"), el("span", { class: "wide" }, t("top.faults", { n })), el("span", { class: "narrow" }, String(n)));
  }

  battery() {
    const battery = this.store.get("battery");
    const box = byId("battery");
    const known = Number.isFinite(battery?.percent);
    const age = this.ages.of("battery", seconds());
    box.classList.toggle("old", known && isOld("battery", age));
    box.classList.toggle("low", Boolean(battery?.low));
    if (!changed(this, known && battery.percent, battery?.charging)) return;
    const name = known ? t("top.battery", { n: battery.percent }) : t("top.battery.unknown");
    const spoken = battery?.charging ? `${name}, ${t("top.charging")}` : name;
    box.setAttribute("aria-label", spoken);
    box.setAttribute("role", "img");
    box.title = spoken;
    const gauge = el("span", { class: "gauge" }, el("span", { class: "level" }));
    gauge.firstChild.style.width = `${known ? Math.max(0, Math.min(100, battery.percent)) : 0}%`;
    fill(box, battery?.charging ? icon("charge") : null, gauge, known ? `${battery.percent} %` : "–");
  }

  // Show the lost connection, and all values as old.
  tick() {
    const { link, store } = this;
    const now = seconds();
    const state = lost({ open: link.open, heardAt: link.heardAt, robotLost: store.get("robotlost"), now });
    const box = byId("lost");
    show(box, state !== null);
    document.body.classList.toggle("gone", state !== null);
    if (state?.who !== this.was?.who) store.set("lost", state);
    this.was = state;
    this.battery();
    if (state === null) {
      this.spoken = "";
      return;
    }
    const who = byId("token").open ? "token" : state.who === "server" && link.heardAt === null ? "first" : state.who;
    const text = t(`lost.${who}`, { n: Math.round(state.since) });
    // A screen reader reads the text once, without the changing seconds.
    const kind = `${who}${current()}`;
    if (this.spoken !== kind) fill(box, icon("warn"), el("span", {}, text));
    else say(box.lastChild, text);
    box.setAttribute("aria-live", this.spoken === kind ? "off" : "assertive");
    this.spoken = kind;
  }
}

// The page of another robot: the first one's is the root, the others' are below robots/NAME/. Pure.
export function pageOf(name, robots, { pathname }) {
  const root = pathname.replace(/(robots\/[^/]+\/)?[^/]*$/, "");
  return name === robots[0] ? root : `${root}robots/${encodeURIComponent(name)}/`;
}

// What the robot does; null if it has not reported.
export const stateText = (store) => store.get("activity") && word("state", store.get("activity"));
