// Downloads one file of the server, with a progress bar, cancel, and the reason of a failure.

import { button, el, fill, say } from "./dom.js";
import { bytes, t } from "./i18n.js";

export const MAX_BYTES = 256e6; // bytes; a larger file is left to the browser's own download

export class Download {
  constructor({ rest, path, name, label = "rec.download", id = null }) {
    Object.assign(this, { rest, path, name, label, id });
    this.root = el("div", { class: "download" });
    this.ending = null;
    this.why = "";
    this.idle();
  }

  idle() {
    this.root.classList.remove("busy");
    fill(this.root, button(t(this.label), () => this.begin(), { id: this.id }), this.why ? el("p", { class: "quiet", role: "status" }, this.why) : null);
  }

  // Show the texts in the current language; a download goes on.
  relabel() {
    if (this.ending === null) this.idle();
  }

  async begin() {
    this.ending = new AbortController();
    const bar = el("progress", { max: 1, "aria-label": `${t(this.label)} ${this.name}` });
    const note = el("p", { class: "quiet" });
    this.root.classList.add("busy");
    fill(this.root, bar, el("div", { class: "underway" }, note, button(t("go.cancel"), () => this.ending?.abort(), { kind: "plain" })));
    try {
      const blob = await this.rest.blob(this.path, (part, size, total) => {
        bar.value = part;
        say(note, t("download.part", { size: bytes(size), total: bytes(total) }));
      }, this.ending.signal);
      save(blob, this.name);
      this.why = t("download.done", { name: this.name });
    } catch (error) {
      this.why = this.ending.signal.aborted ? t("download.ended") : error.message;
    }
    this.ending = null;
    this.idle();
  }
}

function save(blob, name) {
  const url = URL.createObjectURL(blob);
  el("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
}
