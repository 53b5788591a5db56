// The tab Log: the journal of commands; recordings with their download; the files of the map; the page on a phone.

import { button, byId, el, fill, icon, show } from "./dom.js";
import { Download, MAX_BYTES } from "./download.js";
import { bytes, changed, clock, has, number, onLanguage, t, word } from "./i18n.js";
import { attempt, toast } from "./toast.js";
import { whatText, whoText } from "./command_words.js";
import { briefText } from "./reason_words.js";

const FAILED = new Set(["no-room", "not-written"]);

export const ICONS = { running: "wait", ok: "ok", bad: "no", ended: "stop" };

export class LogTab {
  constructor({ store, rest, token }) {
    Object.assign(this, { store, rest, token });
    this.recordBox = el("section", { class: "card", id: "recordings" });
    this.list = el("section", { class: "card", id: "journal" });
    this.downloads = new Map(); // id of a recording, or name of a file -> Download
    this.mapBox = el("section", { class: "card", id: "mapfiles" });
    this.phoneBox = el("section", { class: "card", id: "phone" });
    fill(byId("tab-log"), this.recordBox, this.list, this.mapBox, this.phoneBox);
    store.on("anew", () => this.downloads.clear());
    store.on("journal", () => this.renderJournal());
    store.on("recordings", () => this.renderRecordings());
    onLanguage(() => {
      this.downloads.forEach((one) => one.relabel());
      this.renderJournal();
      this.renderRecordings();
      this.renderMap();
      this.renderPhone();
    });
  }

  renderJournal() {
    const entries = [...(this.store.get("journal") ?? [])].reverse();
    const rows = entries.map((entry) => {
      const { kind } = entry;
      return el("li", { class: `entry ${kind}` }, icon(ICONS[kind]),
        el("div", { class: "grow" },
          el("p", {}, el("strong", {}, whatText(entry))),
          el("p", { class: "quiet" }, [clock(entry.at), whoText(entry.who), word("goal", entry.state), briefText(entry)].filter(Boolean).join(" · "))));
    });
    fill(this.list, el("h2", {}, t("log.title")),
      rows.length ? el("ul", { class: "plainlist" }, ...rows) : el("p", { class: "quiet" }, t("log.none")));
  }

  renderRecordings() {
    const all = this.store.get("recordings") ?? [];
    const running = all.find((one) => one.running);
    const failed = all.find((one) => one.id === this.running && FAILED.has(one.end));
    if (failed) toast(t(`ended.${failed.end}`), "bad");
    this.running = running?.id;
    if (!changed(this, running?.id, all.length)) { // only sizes changed: keep the focus
      if (running) this.growth.textContent = growthOf(running);
      return;
    }
    this.growth = el("span", { class: "grow" }, running ? growthOf(running) : "");
    const begin = () => attempt(() => this.rest.json("POST", "recordings", {}));
    const end = () => attempt(() => this.rest.call("POST", `recordings/${encodeURIComponent(running.id)}/end`, null, { timeout: 20 }));
    const done = all.filter((one) => !one.running).reverse();
    fill(this.recordBox, el("h2", {}, t("rec.title")),
      running ? el("div", { class: "recording" }, el("span", { class: "pulse", "aria-hidden": "true" }),
        this.growth,
        button(t("rec.stop"), end, { kind: "primary", id: "record-stop" }))
        : button(t("rec.start"), begin, { id: "record" }),
      done.length ? el("ul", { class: "plainlist" }, ...done.map((one) => this.row(one)))
        : running ? null : el("p", { class: "quiet" }, t("rec.none")));
  }

  // The browser downloads a large file itself, without this page's memory.
  row(one) {
    const path = `recordings/${encodeURIComponent(one.id)}/bag`;
    const name = one.name ?? `${one.id}.bag`;
    const large = one.bytes > MAX_BYTES;
    return el("li", { class: `saved ${FAILED.has(one.end) ? "bad" : ""}` },
      FAILED.has(one.end) ? icon("warn") : null,
      el("div", { class: "grow" }, el("p", {}, el("strong", {}, name)), el("p", { class: "quiet" }, doneOf(one))),
      large ? el("a", { class: "button", href: this.rest.base + path, download: name }, t("rec.download"))
        : this.download(one.id, { path, name }).root);
  }

  download(key, options) {
    if (!this.downloads.has(key)) this.downloads.set(key, new Download({ rest: this.rest, ...options }));
    return this.downloads.get(key);
  }

  renderMap() {
    fill(this.mapBox, el("h2", {}, t("files.title")), el("p", { class: "quiet" }, t("files.hint")), el("div", { class: "row" },
      ...["png", "yaml"].map((kind) =>
        this.download(`map.${kind}`, { path: `map.${kind}`, name: `map.${kind}`, label: `files.${kind}`, id: `save-${kind}` }).root)));
  }

  // The code contains the token only if it was in the address with which this page was opened.
  renderPhone() {
    const address = location.href.split(/[?#]/)[0] + (this.token ? `#token=${encodeURIComponent(this.token)}` : "");
    const local = /^(localhost|127\.|\[::1\])/.test(location.hostname);
    const picture = el("img", { class: "picture hidden", id: "qr", alt: t("phone.code") });
    const draw = () => attempt(async () => {
      const answer = await this.rest.call("POST", "qr", { text: address });
      picture.src = URL.createObjectURL(await answer.blob());
      show(picture);
      await picture.decode();
      picture.scrollIntoView();
    });
    fill(this.phoneBox, el("h2", {}, t("phone.title")), el("p", { class: "quiet" }, t(local ? "phone.local" : this.token ? "phone.token" : "phone.hint")),
      local ? null : button(t("phone.code"), draw, { id: "show-qr" }), picture);
  }
}

// What was saved, and why if nobody has asked for the end.
const doneOf = (one) => [has(`ended.${one.end}`) ? t(`ended.${one.end}`) : "",
  t("rec.done", { size: bytes(one.bytes), n: number(one.seconds, 0) })].filter(Boolean).join(" ");

const growthOf = (one) => t("rec.running", { size: bytes(one.bytes), n: number(one.seconds, 0) });
