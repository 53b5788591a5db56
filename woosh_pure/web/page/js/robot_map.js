// The robot's own maps: their names and a choice of them in the tab Go, and the zones on the map.

import { ask } from "./confirm.js";
import { el, fill, show } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { attempt, toast } from "./toast.js";

// A zone is a dashed area; one with a speed limit says it.
export function drawZones(context, view, paint, zones) {
  context.lineWidth = 1.5;
  context.strokeStyle = paint.zone;
  context.font = paint.font;
  context.textAlign = "center";
  for (const { points, max_speed: speed } of zones ?? []) {
    context.beginPath();
    points.forEach(([x, y]) => context.lineTo(...view.toScreen(x, y)));
    context.closePath();
    context.globalAlpha = 0.12;
    context.fillStyle = paint.zone;
    context.fill();
    context.globalAlpha = 1;
    context.setLineDash([4, 4]);
    context.stroke();
    context.setLineDash([]);
    if (!speed) continue;
    const middle = (at) => points.reduce((sum, point) => sum + point[at], 0) / points.length;
    context.fillStyle = paint.label;
    context.fillText(`${speed} m/s`, ...view.toScreen(middle(0), middle(1)));
  }
}

// All maps as [scene, map]. Pure.
export const choices = (site) => (site?.scenes ?? []).flatMap(({ name, maps }) => maps.map((map) => [name, map]));

export class MapChoice {
  constructor({ store, rest, lease }) {
    Object.assign(this, { store, rest, lease });
    this.root = el("label", { class: "row", id: "map-choice" });
    store.on("site", () => this.render());
    onLanguage(() => this.render());
  }

  render() {
    const site = this.store.get("site");
    const all = choices(site);
    show(this.root, all.length > 0);
    const used = ([scene, map]) => scene === site.scene && map === site.map;
    const select = el("select", {
      onchange: () => {
        const [scene, map] = all[select.selectedIndex];
        this.render(); // the robot's map is shown until the robot names another one
        ask({ text: t("maps.ask", { scene, map }), note: t("maps.note"), yes: t("maps.switch"), onyes: () => this.send(scene, map) });
      },
    }, ...all.map((each) => el("option", { selected: used(each) }, each.join(" · "))));
    fill(this.root, el("span", { class: "quiet" }, t("maps.title")), select);
  }

  async send(scene, map) {
    toast(t("maps.wait"), "wait");
    const now = await attempt(async () => {
      await this.lease.need();
      return this.rest.json("POST", "scenes/current", { scene, map }, { timeout: 90 });
    });
    if (now) toast(t(now.localised === false ? "maps.lost" : "maps.done", now), now.localised === false ? "bad" : undefined);
  }
}
