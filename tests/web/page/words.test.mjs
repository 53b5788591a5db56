import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

import { bytes, choose, degrees, number, t, use, word } from "../../../woosh_pure/web/page/js/i18n.js";
import { whatText, whoText } from "../../../woosh_pure/web/page/js/command_words.js";
import { en } from "../../../woosh_pure/web/page/js/words_en.js";
import { zh } from "../../../woosh_pure/web/page/js/words_zh.js";

const PAGE = new URL("../../../woosh_pure/web/page/", import.meta.url);
const modules = readdirSync(new URL("js/", PAGE)).filter((name) => name.endsWith(".js"));
const sources = modules.map((name) => readFileSync(new URL(`js/${name}`, PAGE), "utf8"));
const index = readFileSync(new URL("index.html", PAGE), "utf8");

test("both languages have the same sentences with the same places to fill", () => {
  assert.deepEqual(Object.keys(zh).sort(), Object.keys(en).sort());
  const places = (text) => (text.match(/\{\w+\}/g) ?? []).sort().join();
  for (const key of Object.keys(en)) assert.equal(places(zh[key]), places(en[key]), key);
});

test("each sentence that the page asks for is there, and none is left over", () => {
  const text = sources.filter((_, i) => !modules[i].startsWith("words_")).join("\n") + index;
  const forms = [/\bt\(\s*"([\w. ]+)"/g, /data-t(?:-label)?="([^"]+)"/g];
  const asked = forms.flatMap((form) => [...text.matchAll(form)].map((found) => found[1]));
  for (const key of asked) assert.ok(key in en, `${key} is asked for`);
  const built = [...text.matchAll(/`([a-z]+)\.\$\{/g), ...text.matchAll(/word\("([a-z]+)"/g)].map((found) => `${found[1]}.`);
  for (const key of Object.keys(en)) {
    assert.ok(text.includes(`"${key}"`) || built.some((group) => key.startsWith(group)), `${key} is never shown`);
  }
});

test("no file of the page is longer than 300 lines, and none asks anybody outside", () => {
  sources.forEach((source, i) => assert.ok(source.split("\n").length <= 301, modules[i]));
  for (const text of [...sources, index, readFileSync(new URL("base.css", PAGE), "utf8"), readFileSync(new URL("app.css", PAGE), "utf8")]) {
    assert.doesNotMatch(text.replaceAll("http://www.w3.org/2000/svg", ""), /https?:\/\/|@import|url\(|src="\/|href="\//);
  }
  assert.doesNotMatch(index, /<style|style="|onclick=|<script(?![^>]*src=)/);
});

test("the language is the browser's first one that is here", () => {
  assert.equal(choose(["fr-FR", "zh-TW", "en"]), "zh");
  assert.equal(choose(["fr"]), "en");
  assert.equal(choose([]), "en");
});

test("numbers, angles and sizes as people write them", () => {
  use("en");
  assert.equal(number(-0.001, 2), "0.00");
  assert.equal(number(NaN), "–");
  assert.equal(degrees(Math.PI), 180);
  assert.equal(degrees(-1.5 * Math.PI), 90);
  assert.equal(bytes(12_345_678), "12.3 MB");
});

test("a word that is not known is shown as it came", () => {
  assert.equal(word("state", "in task"), "In a task");
  assert.equal(word("state", "unknown 77"), "unknown 77");
  assert.equal(word("state", null), t("unknown"));
});

test("what was asked is told in the language of the page", () => {
  use("zh");
  assert.equal(whatText({ key: "mark", values: { mark: "A1" } }), "前往“A1”");
  assert.equal(whatText({ key: "rotate", values: { angle: 4.712, speed: 0 } }), "旋转 270°");
  assert.equal(whoText("page 3 at 10.0.0.7"), "网页 3（10.0.0.7）");
  use("en");
  assert.equal(whatText({ key: "pose", values: { x: 1, y: -0.5, yaw: 0.36 } }), "Go to x 1.00 m, y -0.50 m");
  assert.equal(whatText({ key: "new kind", values: {}, what: "something new" }), "something new");
  assert.equal(whoText("anna"), "anna");
});

test("a button or page that a sentence names is called so on the page", () => {
  for (const words of [en, zh]) {
    const names = new Set(Object.values(words));
    const named = Object.values(words).flatMap((text) => [...text.matchAll(/“([^”{]+)”/g)].map((found) => found[1]));
    assert.ok(named.length > 3);
    for (const name of named) assert.ok(names.has(name), name);
  }
});
