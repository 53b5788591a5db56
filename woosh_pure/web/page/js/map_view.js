// The map's canvas: draws all layers after a change, at most once a frame, and handles its buttons and gestures.

import { CostmapSwitch } from "./costmap_switch.js";
import { byId, el, fill, say } from "./dom.js";
import { isOld } from "./freshness.js";
import { MapGestures, headingOf, nearest } from "./map_gestures.js";
import { MapBackground } from "./map_background.js";
import { hint } from "./map_hint.js";
import { degrees, number, onLanguage, t } from "./i18n.js";
import * as layers from "./map_layers.js";
import { seconds } from "./live_connection.js";
import { drawZones } from "./robot_map.js";
import { Trail } from "./time_series.js";
import { scaleBar, MapViewport } from "./map_viewport.js";

const KEYS = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] };

export class MapView {
  constructor({ store, ages, rest }) {
    Object.assign(this, { store, ages });
    this.canvas = byId("canvas");
    this.context = this.canvas.getContext("2d");
    this.view = new MapViewport();
    this.trail = new Trail();
    this.following = true;
    this.fitted = false;
    this.whole = false; // the whole map is shown, and was not moved since
    this.asked = false;
    this.chosen = null; // name of the selected mark
    this.place = null; // {x, y, yaw} while something is being placed
    this.placing = null; // called at each change of `place`
    this.onmark = () => {};
    this.ontap = null; // (x, y): in the place of what a tap does else
    this.ground = new MapBackground(store, rest, () => this.change(), (part) => this.progress(part));
    this.paint = layers.paintOf(document.body);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
  }

  listen() {
    const { store } = this;
    store.on("plan site marks obstacles scan lost", () => this.change());
    store.on("pose", (pose) => this.takePose(pose));
    store.on("ground", () => this.takeGround());
    store.on("closer", (on) => (on ? this.closer() : this.fit()));
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => {
      this.paint = layers.paintOf(document.body);
      this.change();
    });
    onLanguage(() => {
      this.canvas.setAttribute("aria-label", t("map.keys"));
      this.texts();
    });
    this.pointers();
    this.tools();
  }

  pointers() {
    const point = (event) => [event.offsetX, event.offsetY];
    const gestures = new MapGestures({
      pan: (dx, dy) => this.moved(() => this.view.panBy(dx, dy)),
      pinch: (...points) => this.moved(() => this.view.pinch(...points)),
      tap: (at) => this.tap(at),
      placing: () => this.placing !== null,
      begin: (at) => this.setPlace(...this.view.toWorld(...at), this.place?.yaw ?? 0),
      drag: (at) => this.turnPlace(at),
      drop: (at) => this.turnPlace(at),
      undo: () => this.setPlace(null),
    });
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      gestures.down(event.pointerId, point(event), seconds());
    });
    canvas.addEventListener("pointermove", (event) => gestures.move(event.pointerId, point(event)));
    canvas.addEventListener("pointerup", (event) => gestures.up(event.pointerId, point(event), seconds()));
    canvas.addEventListener("pointercancel", (event) => gestures.cancel(event.pointerId));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.moved(() => this.view.zoomAt(...point(event), Math.exp(-event.deltaY * 0.0015)), this.following);
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  tools() {
    const { view } = this;
    const zoom = (factor) => this.moved(() => view.zoomAt(view.width / 2, view.height / 2, factor), this.following);
    byId("zoom-in").onclick = () => zoom(1.4);
    byId("zoom-out").onclick = () => zoom(1 / 1.4);
    byId("follow").onclick = () => this.follow(!this.following);
    byId("fit").onclick = () => this.fit();
    this.costmap = new CostmapSwitch({ store: this.store, ground: this.ground, changed: () => this.change() });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key in KEYS) this.moved(() => this.view.panBy(...KEYS[event.key]));
    else if (event.key === "+" || event.key === "=") byId("zoom-in").click();
    else if (event.key === "-") byId("zoom-out").click();
    else return;
    event.preventDefault();
  }

  // The tools over the canvas: a row on a phone, else a column.
  get covered() {
    return this.view.width < 820 ? { top: 60, bottom: 34 } : { right: 72, bottom: 40 };
  }

  moved(change, following = false) {
    change();
    this.whole = false;
    if (!following) this.follow(false);
    this.change();
  }

  follow(on) {
    this.following = on;
    byId("follow").setAttribute("aria-pressed", String(on));
    if (on) {
      this.whole = false;
      this.centre();
    }
  }

  fit() {
    const bounds = this.ground.bounds;
    if (bounds) this.view.fit(bounds, this.covered);
    this.follow(false);
    this.whole = true;
    this.change();
  }

  closer() {
    this.view.scale = Math.max(this.view.scale, 45);
    this.follow(true);
  }

  centre() {
    const pose = this.store.get("pose");
    if (pose) this.view.centre(pose.x, pose.y);
    this.change();
  }

  takePose(pose) {
    if (pose) this.trail.add(pose.x, pose.y);
    if (this.following && this.placing === null) this.centre();
    this.change();
  }

  // Show the first map whole, with all marks.
  takeGround() {
    if (this.ground.meta && !this.fitted) {
      this.fitted = true;
      this.fit();
    }
    hint("none", this.ground.meta ? null : t("map.none"));
    this.change();
  }

  progress(part) {
    const loading = part !== null && part < 1;
    hint("load", loading ? t("map.loading") : null, part);
  }

  tap(at) {
    if (this.ontap) {
      this.ontap(...this.view.toWorld(...at));
      return;
    }
    const [x, y] = this.view.toWorld(at[0], at[1] + 8); // the body of a pin stands above its place
    const mark = nearest(this.store.get("marks"), x, y, 30 / this.view.scale);
    if (mark) this.onmark(mark);
  }

  // Begin or end placing: changed(place) at each change.
  setPlacing(changed, start = null) {
    this.placing = changed;
    this.place = start;
    this.canvas.parentElement.classList.toggle("placing", changed !== null);
    this.change();
  }

  setPlace(x, y, yaw) {
    this.place = x === null ? null : { x, y, yaw };
    this.placing?.(this.place);
    this.change();
  }

  turnPlace(at) {
    if (!this.place) return;
    const [x, y] = this.view.toWorld(...at);
    const { x: ax, y: ay, yaw } = this.place;
    this.setPlace(ax, ay, headingOf(ax, ay, x, y, 14 / this.view.scale, yaw));
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.view.resize(width, height);
    this.ratio = ratio;
    if (this.following) this.centre();
    if (this.whole) this.fit();
    this.draw();
  }

  change() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  draw() {
    const { context, view, paint, store } = this;
    const now = seconds();
    const gone = store.get("lost") !== null;
    const old = (feed) => gone || isOld(feed, this.ages.of(feed, now));
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, view.width, view.height);
    this.ground.draw(context, view);
    const site = store.get("site");
    drawZones(context, view, paint, site?.zones);
    layers.drawPlan(context, view, paint, store.get("plan"));
    layers.drawTrail(context, view, paint, this.trail);
    layers.drawObstacles(context, view, paint, store.get("obstacles"));
    layers.drawScan(context, view, paint, store.get("scan"), old("scan"));
    layers.drawMarks(context, view, paint, store.get("marks"), this.chosen, this.canvas.parentElement.querySelector(".tools"));
    layers.drawRobot(context, view, paint, store.get("pose"), old("pose"), site?.outline);
    layers.drawPlacing(context, view, paint, this.place, site?.outline);
    this.texts();
  }

  texts() {
    const pose = this.store.get("pose");
    const values = pose && { x: number(pose.x, 2), y: number(pose.y, 2), deg: degrees(pose.yaw) };
    say(byId("pose-text"), pose ? t("map.pose", values) : t("map.nopose"));
    const bar = scaleBar(this.view.scale, this.view.width < 600 ? 25 : 60); // a phone's map is small
    const element = byId("scale");
    if (!element.children.length) fill(element, el("span"), el("i"));
    element.lastChild.style.width = `${Math.round(bar.pixels)}px`;
    say(element.firstChild, `${number(bar.metres, bar.metres < 1 ? 1 : 0)} m`);
  }
}
