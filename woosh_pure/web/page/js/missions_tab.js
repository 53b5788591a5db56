// The missions. The card above all tabs, on every page: the step, the question with its answers, pause, resume, end; after a
// restart it asks whether to go on. The tab: the missions to start, with their parameters, to edit, and what was started.

import { ask } from "./confirm.js";
import { button, byId, el, fill, icon, say, show } from "./dom.js";
import { changed, has, number, onLanguage, t, word } from "./i18n.js";
import { ICONS } from "./log_tab.js";
import { MissionEditor, typed } from "./mission_editor.js";
import { said } from "./reason_words.js";
import { kindOf } from "./server_values.js";
import { attempt, toast } from "./toast.js";

const path = (...parts) => parts.map(encodeURIComponent).join("/");
const shown = ([key, value]) => (key === "default" || typeof value === "object" ? [] : [value]);
const stepText = (step) => [t(`step.${step.do}`), ...Object.entries(step.values).flatMap(shown)].join(" ");

class MissionCard {
  constructor({ store, rest }) {
    Object.assign(this, { store, rest, box: byId("mission") });
    store.on("missions lost tab", () => this.render());
    onLanguage(() => this.render());
  }

  render() {
    const runs = this.store.get("missions")?.runs ?? [];
    const run = runs.find((one) => !one.done && one.state !== "queued");
    const ended = runs.find((one) => one.done && one.id === this.seen);
    this.seen = run?.id;
    if (ended) toast(`${ended.mission} · ${word("goal", ended.state)}`, kindOf(ended.state) === "bad" ? "bad" : "ok");
    show(this.box, Boolean(run));
    if (!run) return;
    if (changed(this, run.id, run.state, run.step, run.steps, run.question?.text)) this.build(run);
    const left = run.question?.seconds_left;
    say(this.note, Number.isFinite(left) ? t("mission.default", { n: number(left, 0), answer: run.question.default })
      : [t("mission.step", { n: run.step + 1, of: run.steps.length }), said(run.said)].filter(Boolean).join(" · "));
    this.buttons.disabled = this.store.get("lost")?.who === "server";
  }

  // An answer names its step: one that comes late must not answer the next question.
  build({ id, mission, state, step, steps, question }) {
    const send = (where, body = null) => () => attempt(() => this.rest.call("POST", where, body, { timeout: 20 }));
    const answers = question?.answers.map((answer) =>
      button(has(`answer.${answer}`) && question.unknown ? t(`answer.${answer}`) : answer, send(path("mission-runs", id, "answer"), { step, answer })));
    const halted = ["paused", "interrupted"].includes(state);
    const verb = halted ? "resume" : "pause";
    this.note = el("p", { class: "quiet", "aria-live": "off" });
    this.buttons = el("fieldset", { class: "row" }, ...answers ?? [],
      button(t(`task.${verb}`), send(`mission-queue/${verb}`), { kind: halted ? "primary" : "", id: `mission-${verb}` }),
      button(t("mission.stop"), send("mission-queue/stop"), { id: "mission-stop" }));
    fill(this.box,
      el("div", { class: "head" }, icon("missions"), el("span", { class: "grow" }, el("strong", {}, mission), ` · ${word("goal", state)}`)),
      question ? el("p", { class: "question" }, question.unknown ? t("mission.unknown", { n: step + 1 }) : question.text) : null, this.buttons, this.note,
      el("ol", { class: "steps" }, ...steps.map((one, at) => el("li", { "aria-current": at === step ? "step" : null },
        stepText(one), one.state ? ` · ${word("goal", one.state)}` : ""))));
    if (question || halted) byId("panel").scrollTop = 0; // it is seen without scrolling
  }
}

export class MissionsTab {
  constructor({ store, rest, map }) {
    Object.assign(this, { store, rest, folder: { missions: [] } });
    new MissionCard({ store, rest });
    this.list = el("section", { class: "card", id: "missions" });
    this.runs = el("section", { class: "card", id: "mission-runs" });
    this.editor = new MissionEditor({ store, rest, map, root: byId("tab-missions"), closed: () => this.load() });
    store.on("tab", (tab) => tab === "missions" && this.load());
    store.on("missions", () => this.renderRuns());
    onLanguage(() => this.render());
  }

  async load() {
    this.folder = await attempt(() => this.rest.json("GET", "missions")) ?? this.folder;
    this.render();
  }

  render() {
    if (this.editor.mission) return void this.editor.render();
    const rows = this.folder.missions.map((one) => el("li", { class: "saved" },
      el("div", { class: "grow" }, el("strong", {}, one.mission?.name ?? one.file),
        el("p", { class: one.problem ? "why" : "quiet" }, one.problem ?? one.mission.description)),
      one.problem ? null : button(t("go.start"), () => this.askStart(one), { kind: "primary", "aria-label": t("missions.ask", one.mission) }),
      one.problem ? null : button("…", () => this.editor.open(one, this.folder), { kind: "plain", "aria-label": t("marks.edit", one.mission) })));
    fill(this.list, el("h2", {}, t("tab.missions")), el("p", { class: "quiet" }, t("missions.hint")), el("ul", { class: "plainlist" }, ...rows),
      button(t("missions.new"), () => this.editor.open(null, this.folder), { name: "plus", id: "mission-new" }));
    fill(byId("tab-missions"), this.list, this.runs);
    this.shown = null;
    this.renderRuns();
  }

  // The parameters are asked for; a number stays a number.
  askStart({ file, mission: { name, parameters = {} } }) {
    const inputs = Object.entries(parameters).map(([key, value]) => [key, value, el("input", { value, maxlength: 200, required: true, id: `parameter-${key}` })]);
    const types = { number: "number", boolean: "bool" };
    const given = () => Object.fromEntries(inputs.map(([key, value, input]) => [key, typed(types[typeof value], input.value)]));
    const begin = () => attempt(() => this.rest.call("POST", "mission-runs", { file, parameters: given() }, { timeout: 20 }));
    const fields = inputs.map(([key, , input]) => el("label", {}, el("span", {}, key), input));
    ask({ text: t("missions.ask", { name }), note: t("go.clear"), yes: t("go.start"), fields, onyes: begin });
  }

  // What was started, the newest first, and the queue above it.
  renderRuns() {
    const { runs = [], paused = false, problem = null } = this.store.get("missions") ?? {};
    if (!changed(this, paused, problem, runs.map(({ id, state }) => [id, state]))) return;
    const send = (method, where) => () => attempt(() => this.rest.call(method, where));
    const queued = runs.some(({ state }) => state === "queued") && runs.every(({ done, state }) => done || state === "queued");
    const rows = [...runs].reverse().map(({ id, mission, state, said: why, done }) => el("li", { class: `entry ${done ? kindOf(state) : "running"}` },
      icon(ICONS[done ? kindOf(state) : "running"]),
      el("div", { class: "grow" }, el("strong", {}, mission), el("p", { class: "quiet" }, [word("goal", state), done ? said(why) : ""].filter(Boolean).join(" · "))),
      state === "queued" ? button("×", send("DELETE", path("mission-runs", id)), { kind: "close", "aria-label": t("missions.remove", { name: mission }) }) : null));
    fill(this.runs, el("h2", {}, t("missions.runs")), problem ? el("p", { class: "why" }, said(problem)) : null, el("ul", { class: "plainlist" }, ...rows),
      paused && queued ? button(t("task.resume"), send("POST", "mission-queue/resume"), { id: "queue-resume" }) : null);
    show(this.runs, rows.length > 0 || problem !== null);
  }
}
