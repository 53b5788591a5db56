// The list of marks in the tab Go: search, drive to one, save, change, delete. All pages of the server share it.

import { ask } from "./confirm.js";
import { button, el, fill, icon, say, show } from "./dom.js";
import { number, onLanguage, t } from "./i18n.js";
import { attempt, toast } from "./toast.js";

// The marks whose name or note has the typed letters. Pure.
export function found(marks, typed) {
  const wanted = typed.trim().toLowerCase();
  return marks.filter((mark) => `${mark.name}\n${mark.note ?? ""}`.toLowerCase().includes(wanted));
}

export class MarkList {
  // go: askMark(mark) and placing(question), endPlacing()
  constructor({ store, rest, go }) {
    Object.assign(this, { store, rest, go });
    this.root = el("section", { id: "marks" });
    this.distances = new Map();
    this.typed = "";
    store.on("marks", () => this.list());
    store.on("pose", () => this.updateDistances());
    onLanguage(() => this.render());
    this.render();
  }

  get all() {
    return this.store.get("marks") ?? [];
  }

  render() {
    const search = el("input", {
      type: "search", placeholder: t("marks.search"), "aria-label": t("marks.search"), id: "mark-search", maxlength: 100, autocomplete: "off", value: this.typed,
      oninput: () => {
        this.typed = search.value;
        this.list();
      },
    });
    this.rows = el("ul", { class: "marks", id: "mark-list" });
    this.none = el("p", { class: "quiet", id: "no-marks" }, t("marks.none"));
    fill(
      this.root,
      this.none,
      el("form", { class: "inline", onsubmit: (event) => this.submit(event) }, el("h2", {}, t("go.title")), search),
      this.rows,
      el("div", { class: "row" },
        button(t("marks.here"), () => this.addHere(), { name: "plus", id: "mark-here" }),
        button(t("marks.place"), () => this.addPlace(), { name: "plus", id: "mark-place" })),
    );
    this.list();
  }

  // Enter goes to the only match, or else to a mark that only the robot knows.
  submit(event) {
    event.preventDefault();
    const name = this.typed.trim();
    const left = found(this.all, name);
    const mark = left.find((each) => each.name === name) ?? (left.length === 1 ? left[0] : { name });
    this.go.askMark(mark);
  }

  list() {
    const name = this.typed.trim();
    const left = found(this.all, name);
    this.distances.clear();
    show(this.none, !this.all.length);
    const other = name && !left.some((mark) => mark.name === name) ? this.other(name) : null;
    fill(this.rows, ...left.map((mark) => this.row(mark)), other);
    show(this.rows, this.rows.children.length > 0);
    this.updateDistances();
  }

  row(mark) {
    const away = el("span", { class: "quiet away" });
    this.distances.set(mark, away);
    const { charger } = mark;
    const about = [charger ? t("mark.charger") : "", mark.note].filter(Boolean).map((text) => ` · ${text}`).join("");
    return el("li", {},
      el("button", { type: "button", class: "markrow", onclick: () => this.go.askMark(mark) },
        el("span", { class: `dot ${charger ? "charger" : ""}` }, icon(charger ? "charge" : "go")),
        el("span", { class: "grow" }, el("strong", {}, mark.name), el("span", { class: "quiet" }, about), el("br"), away),
        el("span", { class: "go" }, t("go.go"))),
      mark.source === "robot" ? null : button("…", () => this.edit(mark), { kind: "plain", "aria-label": t("marks.edit", { name: mark.name }) }));
  }

  other(name) {
    return el("li", {}, el("button", { type: "button", class: "markrow", id: "mark-other", onclick: () => this.go.askMark({ name }) },
      el("span", { class: "dot" }, icon("go")),
      el("span", { class: "grow" }, el("strong", {}, name), el("br"), el("span", { class: "quiet" }, t("marks.other"))),
      el("span", { class: "go" }, t("go.go"))));
  }

  updateDistances() {
    const pose = this.store.get("pose");
    for (const [mark, element] of this.distances) {
      const known = Number.isFinite(mark.x);
      const away = known && pose ? number(Math.hypot(mark.x - pose.x, mark.y - pose.y), 1) : null;
      say(element, away !== null ? t("go.away", { n: away }) : known ? "" : t("go.noplace"));
    }
  }

  // -- saving, changing, deleting

  text(id, words, value, more = {}) {
    const input = el("input", { type: "text", id, value, maxlength: 100, autocomplete: "off", ...more });
    return [input, el("label", {}, el("span", {}, words), input)];
  }

  // A new mark takes a name only; the rest can be changed afterwards.
  name(own = "") {
    const parts = this.text("mark-name", t("marks.name"), own, { required: true, oninput: () => this.check(parts[0], own) });
    return parts;
  }

  check(input, own) {
    const name = input.value.trim();
    const taken = name !== own && this.all.some((mark) => mark.name === name);
    input.setCustomValidity(taken ? t("marks.taken") : name ? "" : t("marks.name"));
  }

  async send(method, path, body, done) {
    const ok = await attempt(async () => {
      await this.rest.call(method, path, body);
      return true;
    });
    if (ok) toast(done);
  }

  addHere() {
    this.go.endPlacing();
    const [input, label] = this.name();
    const save = () => this.send("POST", "marks", { name: input.value.trim(), here: true }, t("marks.saved"));
    ask({ text: t("marks.hereask"), note: t("marks.herenote"), yes: t("marks.save"), fields: [label], onyes: save });
    input.focus();
  }

  addPlace() {
    this.go.placing((start, numbers) => {
      const [input, label] = this.name();
      const save = () => {
        const place = this.go.endPlacing() ?? start;
        this.send("POST", "marks", { name: input.value.trim(), ...place }, t("marks.saved"));
      };
      ask({ text: t("marks.placeask"), note: t("marks.placehint"), yes: t("marks.save"), fields: [label, ...numbers], onyes: save, onno: () => this.go.endPlacing() });
    });
  }

  edit(mark) {
    this.go.endPlacing();
    const [name, nameLabel] = this.name(mark.name);
    const [note, noteLabel] = this.text("mark-note", t("marks.note"), mark.note ?? "");
    const charger = el("input", { type: "checkbox", id: "mark-charger", checked: Boolean(mark.charger) });
    const known = el("input", { type: "checkbox", id: "mark-known", checked: mark.on_chassis !== false });
    const check = (text, box) => el("label", { class: "check" }, box, el("span", {}, text));
    const path = `marks/${encodeURIComponent(mark.name)}`;
    const more = el("div", { class: "row" },
      button(t("marks.move"), () => this.askMove(mark, path), { id: "mark-move" }),
      button(t("marks.delete"), () => this.askDelete(mark, path), { id: "mark-delete" }));
    const body = () => ({
      name: name.value.trim(), note: note.value.trim(), charger: charger.checked, on_chassis: known.checked,
    });
    const save = () => this.send("PATCH", path, body(), t("marks.saved"));
    const fields = [nameLabel, noteLabel, check(t("marks.charger"), charger), check(t("marks.known"), known), more];
    ask({ text: t("marks.edit", { name: mark.name }), yes: t("marks.save"), fields, onyes: save });
  }

  askMove({ name }, path) {
    const move = () => this.send("PATCH", path, { here: true }, t("marks.saved"));
    ask({ text: t("marks.moveask", { name }), note: t("marks.herenote"), yes: t("marks.move"), onyes: move });
  }

  askDelete({ name }, path) {
    const remove = () => this.send("DELETE", path, null, t("marks.deleted", { name }));
    ask({ text: t("marks.deleteask", { name }), note: t("marks.deletenote"), yes: t("marks.delete"), onyes: remove });
  }
}
