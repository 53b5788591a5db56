// The editor of a mission: a list of steps, each with the keys of its kind. A mark touched on the map is taken for the step
// chosen last, or becomes a new step. The server checks what is saved, and says which step is wrong.

import { button, byId, el, fill, say } from "./dom.js";
import { t } from "./i18n.js";
import { toast } from "./toast.js";

const [NEW, MAX_ANSWERS] = ["go_to_mark", 5];

// What was typed, as the file has it: a number or true where that is expected, else a text, such as "$name" of a parameter. Pure.
export function typed(type, text) {
  if (type === "bool" && /^(true|false)$/.test(text)) return text === "true";
  return /^(number|whole)$/.test(type) && text.trim() && Number.isFinite(Number(text)) ? Number(text) : text;
}

export class MissionEditor {
  constructor({ store, rest, map, root, closed }) {
    Object.assign(this, { store, rest, root, closed, mission: null });
    const before = map.onmark;
    map.onmark = (mark) => (this.mission && store.get("tab") === "missions" ? this.pick(mark.name) : before(mark));
  }

  // A mission of the folder, or with null a new one.
  open(one, folder) {
    this.mission = structuredClone(one?.mission ?? { mission: 1, name: "", step: [] });
    Object.assign(this, { one, folder, wanted: null });
    this.render();
  }

  close() {
    this.mission = null;
    this.closed();
  }

  pick(mark) {
    if (!this.wanted?.isConnected) return this.add({ do: NEW, mark });
    this.wanted.value = mark;
    return this.wanted.oninput();
  }

  add(step) {
    this.mission.step.push(step);
    this.render();
    byId("mission-steps").lastChild.scrollIntoView({ block: "nearest" });
  }

  render() {
    const { mission, one } = this;
    this.why = el("p", { class: "why", role: "alert" });
    fill(this.root, el("form", { class: "card", id: "editor", onsubmit: (event) => this.save(event) },
      this.input("mission-name", t("marks.name"), mission, "name", { required: true, maxlength: 100 }),
      this.input("mission-about", t("marks.note"), mission, "description", { maxlength: 500 }),
      el("p", { class: "quiet" }, t("missions.pick")),
      el("ol", { class: "plainlist", id: "mission-steps" }, ...mission.step.map((step, at) => this.step(step, at))),
      button(t("missions.add"), () => this.add({ do: NEW }), { name: "plus", id: "mission-add" }), this.why,
      el("div", { class: "row" }, el("button", { class: "primary", id: "mission-save" }, t("marks.save")),
        button(t("go.cancel"), () => this.close(), { kind: "plain" }),
        one && button(t("marks.delete"), () => this.send("DELETE", one.file, null, t("marks.deleted", mission)), { id: "mission-delete" }))));
  }

  step(step, at) {
    const { step: steps } = this.mission;
    const change = (sign, key, act) => button(sign, () => {
      act();
      this.render();
    }, { kind: "plain", "aria-label": t(key, { n: at + 1 }) });
    const kind = el("select", { id: `step-${at}`, "aria-label": t("missions.kind", { n: at + 1 }), onchange: () => {
      steps[at] = { do: kind.value, name: step.name };
      this.render();
    } }, ...Object.keys(this.folder.kinds).map((one) => el("option", { value: one, selected: one === step.do }, t(`step.${one}`))));
    const fields = (keys) => el("div", { class: "keys" }, ...Object.entries(keys).map(([key, row]) => this.key(step, key, row, `step-${at}-${key}`)));
    return el("li", {},
      el("div", { class: "inline" }, kind, at ? change("↑", "missions.up", () => steps.splice(at - 1, 2, step, steps[at - 1])) : null,
        change("×", "missions.drop", () => steps.splice(at, 1))),
      fields(this.folder.kinds[step.do] ?? {}),
      el("details", { open: Object.keys(this.folder.common).some((key) => step[key]) }, el("summary", {}, t("missions.more")), fields(this.folder.common)));
  }

  // The control of one key: an empty one leaves its default.
  key(step, key, row, id) {
    const label = t(`key.${key}`);
    if (row.type === "table") return this.pairs(step, key, id, label);
    const more = { required: row.default === null, placeholder: row.default || null, maxlength: 500 };
    const field = this.input(id, label, step, key, more, row);
    if (row.type === "mark") field.children[1].onfocus = () => (this.wanted = field.children[1]);
    return field;
  }

  input(id, label, owner, key, more, row = { type: "text", names: [] }) {
    const names = { mark: () => (this.store.get("marks") ?? []).map((mark) => mark.name), bool: () => ["true", "false"],
      target: () => [...this.mission.step.map((step) => step.name).filter(Boolean), "next", "end", "stop"] }[row.type]?.() ?? row.names;
    const input = el("input", { type: "text", id, value: owner[key] ?? "", autocomplete: "off", list: names.length ? `${id}-names` : null, ...more });
    input.oninput = () => (input.value === "" ? delete owner[key] : (owner[key] = typed(row.type, input.value)));
    return el("label", {}, el("span", {}, label), input, el("datalist", { id: `${id}-names` }, ...names.map((name) => el("option", { value: name }))));
  }

  // A table: the answers of a question with the step that each leads to, or their inputs.
  pairs(step, key, id, label) {
    const pairs = Object.entries(step[key] ?? {}).map(([name, value]) => ({ name, value }));
    while (pairs.length < MAX_ANSWERS) pairs.push({});
    const leads = key === "answers";
    const [to, empty, row] = leads ? [t("key.then"), "next", { type: "target", names: [] }] : [`${label} ${t("key.is")}`, "", { type: "number", names: [] }];
    const keep = () => {
      step[key] = Object.fromEntries(pairs.filter((one) => one.name).map((one) => [one.name, one.value ?? empty]));
      if (!leads && !Object.keys(step[key]).length) delete step[key];
    };
    return el("div", { class: "pairs", oninput: keep },
      ...pairs.map((one, at) => el("div", { class: "inline" }, this.input(`${id}-${at}`, `${label} ${at + 1}`, one, "name", { maxlength: 100 }),
        this.input(`${id}-${at}-to`, to, one, "value", { maxlength: 100, placeholder: empty || null }, row))));
  }

  save(event) {
    event.preventDefault();
    const { mission, one, folder } = this;
    const file = one?.file ?? mission.name.trim();
    if (!one && folder.missions.some((other) => other.file === file)) return say(this.why, t("missions.taken"));
    return this.send("PUT", file, { mission }, t("marks.saved"));
  }

  // A refusal is shown, and the editor stays open.
  async send(method, file, body, done) {
    say(this.why, "");
    try {
      await this.rest.call(method, `missions/${encodeURIComponent(file)}`, body);
      toast(done);
      this.close();
    } catch (error) {
      say(this.why, error.message);
    }
  }
}
