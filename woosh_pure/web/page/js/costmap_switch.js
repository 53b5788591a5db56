// The switch of the costmap, and what is said of it: not every robot publishes one, and a button that does nothing
// would be a riddle.

import { byId } from "./dom.js";
import { hint } from "./map_hint.js";
import { onLanguage, t } from "./i18n.js";

const PATIENCE = 5; // seconds until it is said that none comes

export class CostmapSwitch {
  constructor({ store, ground, changed }) {
    Object.assign(this, { store, ground, changed });
    this.button = byId("costmap");
    this.button.onclick = () => this.turn(!this.ground.costShown);
    this.timer = null;
    this.none = false;
    store.on("costmap", (frame) => frame && this.wait(false));
    onLanguage(() => this.say());
  }

  turn(on) {
    this.ground.costShown = on;
    if (on) this.ground.cost = null; // that of before is old
    this.button.setAttribute("aria-pressed", String(on));
    this.store.set("wantcostmap", on);
    this.wait(on);
    this.changed();
  }

  wait(on) {
    clearTimeout(this.timer);
    this.none = false;
    if (on) this.timer = setTimeout(() => this.missing(), PATIENCE * 1000);
    this.say();
  }

  missing() {
    this.none = true;
    this.say();
  }

  say() {
    const waiting = this.ground.costShown && this.ground.cost === null;
    hint("cost", waiting ? t(this.none ? "map.costnone" : "map.costwait") : null);
  }
}
