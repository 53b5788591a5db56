// The hint over the map: the most urgent one of those that are set, with a progress bar while something loads.

import { byId, el, fill, say, show } from "./dom.js";

const ORDER = ["load", "cost", "none"];
const said = new Map(); // kind -> {text, part}

// Set the hint of a kind, or remove it; `part` is the progress, 0 to 1.
export function hint(kind, text = null, part = null) {
  if (text === null) said.delete(kind);
  else said.set(kind, { text, part });
  const first = ORDER.map((each) => said.get(each)).find(Boolean);
  const box = byId("hint");
  show(box, Boolean(first));
  if (!first) return;
  if (box.children.length !== 2) fill(box, el("span", {}), el("progress", { max: 1 }));
  const [words, bar] = box.children;
  say(words, first.text);
  show(bar, first.part !== null);
  bar.value = first.part ?? 0;
}
