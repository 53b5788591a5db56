// The tab Simulator, which only a simulated robot has: what happens to the robot, and what a tap on the map does.

import { ClassList } from "./class_list.js";
import { button, byId, el, fill } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { attempt } from "./toast.js";

const NOW = {
  press: { do: "press_emergency_stop" }, release: { do: "release_emergency_stop" }, lose: { do: "lose_localization" },
  battery: { battery: 10 }, clear: { do: "remove_obstacles" }, reset: { do: "reset" },
};
const TAPS = ["obstacle", "teleport"];
const SPEEDS = [0.5, 1, 2, 5, 10];

export class SimulatorTab {
  constructor({ store, rest, map }) {
    Object.assign(this, { store, rest, map, speed: 1, all: new ClassList({ store, rest }) });
    store.on("hello", ({ simulator }) => {
      this.speed = simulator?.speed ?? 1;
      this.render();
    });
    store.on("tab", () => this.choose(null));
    onLanguage(() => this.render());
  }

  send(body) {
    return attempt(() => this.rest.call("POST", "simulator", body));
  }

  // What a tap on the map does from now on: one of TAPS, or null, an ordinary tap. The robot keeps its heading.
  choose(what) {
    this.chosen = what;
    this.map.ontap = what && ((x, y) => this.send({ [what]: { x, y, yaw: this.store.get("pose")?.yaw ?? 0 } }));
    this.render();
  }

  render() {
    const taps = TAPS.map((what) => button(t(`sim.${what}`), () => this.choose(what === this.chosen ? null : what),
      { "aria-pressed": String(what === this.chosen), id: `sim-${what}` }));
    const acts = Object.entries(NOW).map(([what, body]) => button(t(`sim.${what}`), () => this.send(body), { id: `sim-${what}` }));
    const speed = el("select", { id: "sim-speed", onchange: () => this.send({ speed: (this.speed = Number(speed.value)) }) },
      ...[...new Set([...SPEEDS, this.speed])].sort((a, b) => a - b)
        .map((each) => el("option", { value: each, selected: each === this.speed }, `${each} ×`)));
    fill(byId("tab-sim"), el("div", { class: "actions" }, ...taps, ...acts),
      el("label", { class: "slider" }, el("span", {}, t("sim.speed")), speed), this.all.box);
    this.all.render();
  }
}
