// The button that shows the costmap, and the hint if the robot publishes none.

import { byId } from "./dom.js";
import { hint } from "./map_hint.js";
import { onLanguage, t } from "./i18n.js";

const MISSING_SECONDS = 5; // seconds until the hint that there is none

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
    if (on) this.ground.cost = null; // the previous one is out of date
    this.button.setAttribute("aria-pressed", String(on));
    this.store.set("wantcostmap", on);
    this.wait(on);
    this.changed();
  }

  wait(on) {
    clearTimeout(this.timer);
    this.none = false;
    if (on) this.timer = setTimeout(() => this.missing(), MISSING_SECONDS * 1000);
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
