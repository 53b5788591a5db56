// The tab Go: drive to a mark or a place, by a distance or angle, charge, and correct the robot's position.

import { ask, dismiss, recheck } from "./confirm.js";
import { button, byId, el, fill, show } from "./dom.js";
import { degrees, inDegrees, number, onLanguage, t } from "./i18n.js";
import { MarkList } from "./mark_list.js";
import { MapChoice } from "./robot_map.js";
import { answerOf, isLost } from "./pose_confirmation.js";
import { hindrance, placeHindrance } from "./reason_words.js";
import { keep, kept } from "./storage.js";
import { attempt, toast } from "./toast.js";

const KNOWN = "woosh-has-driven";
const radians = (value) => (value * Math.PI) / 180;

export class GoTab {
  constructor({ store, rest, map, lease }) {
    Object.assign(this, { store, rest, map, lease });
    this.root = byId("tab-go");
    this.marks = new MarkList({ store, rest, go: this });
    this.maps = new MapChoice({ store, rest, lease });
    this.known = kept(KNOWN) !== null; // no hint for a person who has started a goal before
    map.onmark = (mark) => this.askMark(mark);
    store.on("readiness lost", recheck);
    store.on("stopping", dismiss);
    store.on("marks", (marks) => show(this.first, marks.length > 0 && !this.known));
    onLanguage(() => this.render());
  }

  render() {
    this.first = el("p", { class: "quiet" }, t("go.first"));
    show(this.first, this.marks.all.length > 0 && !this.known);
    fill(
      this.root,
      this.maps.root,
      this.marks.root,
      this.first,
      el("div", { class: "actions" },
        button(t("go.place"), () => this.choosePlace(), { name: "place", id: "choose-place" }),
        button(t("go.charge"), () => this.askCharge(), { name: "charge", id: "charge" }),
        button(t("go.pose"), () => this.choosePose(), { name: "pose", id: "choose-pose" })),
      this.amounts(),
    );
  }

  amounts() {
    const line = (name, label, unit, value, begin) => {
      const input = el("input", { type: "number", step: "any", value, id: `amount-${name}`, required: true });
      return el("form", {
        class: "amount", onsubmit: (event) => {
          event.preventDefault();
          begin(Number(input.value));
        },
      }, el("label", { for: `amount-${name}` }, label), input, el("span", { class: "quiet" }, unit), el("button", {}, t("go.do")));
    };
    return el("section", { class: "card" },
      el("h3", {}, t("go.amounts")),
      line("move", t("go.move"), t("go.metres"), "0.5", (n) => this.askAmount({ kind: "move", distance: n }, n, "go.moveask", 2)),
      line("turn", t("go.turn"), t("go.degrees"), "90", (n) => this.askAmount({ kind: "rotate", angle: radians(n) }, n, "go.turnask", 0)));
  }

  // -- questions, then goals

  confirm(text, body, note = t("go.clear"), more = {}) {
    const replace = Boolean(this.store.get("goal")?.running);
    ask({
      text, note, yes: t(replace ? "go.replace" : "go.start"),
      onyes: () => this.send({ ...body(), replace }), hindered: () => placeHindrance(this.store), ...more,
    });
  }

  askMark(mark) {
    if (!mark.name) return;
    this.endPlacing();
    this.map.chosen = mark.name;
    this.map.change();
    const clear = () => {
      this.map.chosen = null;
      this.map.change();
    };
    const body = () => {
      clear();
      return { kind: "mark", mark: mark.name };
    };
    this.confirm(t("go.mark", { name: mark.name }), body, t("go.clear"), { onno: clear });
  }

  askCharge() {
    this.endPlacing();
    const input = el("input", { type: "text", required: true, maxlength: 100, id: "charger-name", list: "charger-names", autocomplete: "off" });
    const chargers = (this.store.get("marks") ?? []).filter((mark) => mark.charger && mark.on_chassis !== false).map((mark) => mark.name);
    input.value = chargers[0] ?? "";
    const names = el("datalist", { id: "charger-names" }, ...chargers.map((name) => el("option", { value: name })));
    const field = el("label", {}, el("span", {}, t("go.charger")), input, names);
    this.confirm(t("go.chargeask"), () => ({ kind: "charge", mark: input.value.trim() }), t("go.clear"), { fields: [field] });
  }

  askAmount(body, amount, key, digits) {
    if (!Number.isFinite(amount) || amount === 0) {
      toast(t("go.number"), "bad");
      return;
    }
    this.endPlacing();
    this.confirm(t(key, { n: number(amount, digits) }), () => body, t("go.amountsclear"), { hindered: () => hindrance(this.store) });
  }

  choosePlace() {
    this.placing((place, fields) => {
      const body = () => ({ kind: "pose", ...this.endPlacing() ?? place });
      this.confirm(t("go.here"), body, t("go.placehint"), { fields, onno: () => this.endPlacing() });
    });
  }

  choosePose() {
    this.placing((place, fields) => ask({
      text: t("go.poseask"), note: `${t("go.posehint")} ${t("go.posenote")}`, yes: t("go.poseyes"), fields,
      onyes: () => this.sendPose(this.endPlacing() ?? place), onno: () => this.endPlacing(),
    }));
  }

  // Dragging on the map and typing numbers change the same place.
  placing(question) {
    dismiss();
    const pose = this.store.get("pose");
    const start = pose ? { ...pose } : { x: 0, y: 0, yaw: 0 };
    const fields = ["x", "y", "heading"].map((name) => el("input", {
      type: "number", step: "any", required: true, id: `place-${name}`, oninput: () => typed(),
    }));
    const [x, y, heading] = fields;
    const typed = () => {
      const values = fields.map((field) => Number(field.value));
      if (values.every(Number.isFinite)) this.map.place = { x: values[0], y: values[1], yaw: radians(values[2]) };
      this.map.change();
    };
    const placed = (place) => {
      if (!place) return;
      x.value = place.x.toFixed(2);
      y.value = place.y.toFixed(2);
      heading.value = degrees(place.yaw);
    };
    const label = (text, input) => el("label", {}, el("span", {}, text), input);
    const grid = el("div", { class: "fields" }, label("x m", x), label("y m", y), label(t("go.heading"), heading));
    question(start, [grid]);
    this.map.follow(false);
    this.map.setPlacing(placed, start);
    placed(start);
  }

  // Return the chosen place.
  endPlacing() {
    const { place } = this.map;
    this.map.setPlacing(null);
    return place && { x: place.x, y: place.y, yaw: place.yaw };
  }

  async send(body) {
    const begun = await attempt(async () => {
      await this.lease.need();
      return this.rest.json("POST", "goals", body, { timeout: 20 });
    });
    if (begun === null || this.known) return;
    this.known = true;
    keep(KNOWN, "1");
    this.render();
  }

  // Success is shown only when the robot reports the new pose.
  async sendPose(place) {
    const lost = isLost(this.store);
    const done = await attempt(async () => {
      await this.lease.need();
      await this.rest.call("POST", "pose", place, { timeout: 20 });
      return true;
    });
    if (done === null) return;
    const waiting = toast(t("go.posewait"), "wait");
    const answer = await answerOf(this.store, place, lost);
    waiting.remove();
    if (answer?.taken) toast(t("go.posedone"));
    else if (!answer || answer.lost) toast(t(answer ? "go.poselost" : "go.posesilent"), "bad");
    else toast(t("go.poseother", { n: number(answer.away, 1), deg: number(inDegrees(answer.turned), 0) }), "ask");
  }
}
