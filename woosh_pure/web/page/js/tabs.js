// The tabs of the panel, the last one for a simulated robot only; arrow keys move between them. The address names the open one.

import { byId, el, fill, icon, show } from "./dom.js";
import { onLanguage, t } from "./i18n.js";

export const TABS = ["go", "missions", "drive", "camera", "health", "log", "sim"];

export class Tabs {
  constructor(store) {
    this.store = store;
    this.buttons = new Map();
    for (const name of TABS) {
      const label = el("span");
      const button = el("button", {
        type: "button", role: "tab", class: name === "sim" ? "hidden" : "", id: `tabbutton-${name}`, "aria-controls": `tab-${name}`,
        onclick: () => this.choose(name), onkeydown: (event) => this.key(event, name),
      }, icon(name), label);
      this.buttons.set(name, { button, label });
    }
    fill(byId("tabs"), ...[...this.buttons.values()].map(({ button }) => button));
    onLanguage(() => this.buttons.forEach(({ label }, name) => (label.textContent = t(`tab.${name}`))));
    store.on("hello", ({ simulator }) => show(this.buttons.get("sim").button, Boolean(simulator)));
    this.choose(TABS[0]);
  }

  choose(name) {
    for (const [other, { button }] of this.buttons) {
      const chosen = other === name;
      button.setAttribute("aria-selected", String(chosen));
      button.tabIndex = chosen ? 0 : -1;
      show(byId(`tab-${other}`), chosen);
    }
    document.body.dataset.tab = name;
    byId("panel").scrollTop = 0;
    this.store.set("tab", name);
  }

  key(event, name) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const shown = TABS.filter((each) => !this.buttons.get(each).button.classList.contains("hidden"));
    const next = shown[(shown.indexOf(name) + step + shown.length) % shown.length];
    this.choose(next);
    this.buttons.get(next).button.focus();
  }
}
