// One sentence over the map at a time: the most urgent of those that are to be said, with a bar where something loads.

import { byId, el, fill, say, show } from "./dom.js";

const ORDER = ["place", "load", "cost", "none"];
const said = new Map(); // kind -> {text, part}

// Say a hint of that kind, or nothing more; `part` is how far something is, 0 to 1.
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
