// The tab Camera. Pictures are sent only while the tab is open and the page visible.

import { button, byId, el, fill, say, show } from "./dom.js";
import { number, onLanguage, t } from "./i18n.js";
import { seconds } from "./live_connection.js";

const SOURCES = ["color", "depth", null];

export class CameraTab {
  constructor({ store, link }) {
    this.store = store;
    this.link = link;
    this.source = "color";
    this.looked = "";
    this.shownAt = null;
    this.canvas = el("canvas", { class: "picture", role: "img" });
    this.note = el("p", { class: "quiet", role: "status" });
    this.buttons = el("div", { class: "segments", role: "group" });
    fill(byId("tab-camera"), this.buttons, this.canvas, this.note);
    store.on("camera", (frame) => this.take(frame));
    store.on("tab wantcostmap", () => this.look());
    store.on("hello", () => {
      this.looked = ""; // a new session has no cameras switched on
      this.look();
    });
    document.addEventListener("visibilitychange", () => this.look());
    onLanguage(() => this.render());
    setInterval(() => this.tick(), 500);
  }

  get wanted() {
    return this.store.get("tab") === "camera" && !document.hidden ? this.source : null;
  }

  look() {
    const message = { t: "look", camera: this.wanted, costmap: Boolean(this.store.get("wantcostmap")) && !document.hidden };
    const text = JSON.stringify(message);
    if (text === this.looked) return;
    if (this.link.send(message)) this.looked = text;
    this.tick();
  }

  render() {
    fill(this.buttons, ...SOURCES.map((source) => button(t(`camera.${source ?? "off"}`), () => {
      this.source = source;
      this.shownAt = null;
      this.render();
      this.look();
    }, { "aria-pressed": String(source === this.source) })));
    this.canvas.setAttribute("aria-label", t("camera.alt"));
    show(this.canvas, this.source !== null);
    this.tick();
  }

  async take(frame) {
    if (frame.source !== this.wanted) return; // a late picture of the other camera
    const picture = await createImageBitmap(new Blob([frame.jpeg], { type: "image/jpeg" })).catch(() => null);
    if (picture === null) return;
    if (this.canvas.width !== picture.width || this.canvas.height !== picture.height) {
      this.canvas.width = picture.width;
      this.canvas.height = picture.height;
    }
    this.canvas.getContext("2d").drawImage(picture, 0, 0);
    picture.close();
    this.shownAt = seconds();
    this.tick();
  }

  tick() {
    const age = this.shownAt === null ? null : seconds() - this.shownAt;
    this.canvas.classList.toggle("old", age === null || age > 2);
    if (this.wanted === null) say(this.note, t("camera.hint"));
    else if (age === null) say(this.note, t("camera.wait"));
    else say(this.note, age > 2 ? t("camera.old", { n: number(age, 0) }) : t("camera.hint"));
  }
}
