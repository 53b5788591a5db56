// The page's language, and its texts by key in English and Chinese. Text without an entry is shown unchanged.

import { en } from "./words_en.js";
import { zh } from "./words_zh.js";

const LANGUAGES = { en, zh };
const listeners = new Set();
let language = "en";

export const current = () => language;

// The first supported language of the browser.
export function choose(wanted) {
  for (const tag of wanted) {
    const short = String(tag).slice(0, 2).toLowerCase();
    if (short in LANGUAGES) return short;
  }
  return "en";
}

export function use(name) {
  language = name in LANGUAGES ? name : "en";
  for (const listener of listeners) listener(language);
}

export const onLanguage = (listener) => listeners.add(listener);

const plain = (text, values) => text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? values[name] : whole));

export function t(key, values = {}) {
  const text = LANGUAGES[language][key] ?? en[key];
  return text === undefined ? key : plain(text, values);
}

export const has = (key) => key in en;

// Translate a term of the library ("in task"); unchanged without an entry.
export const word = (group, value) => {
  if (value === null || value === undefined || value === "") return t("unknown");
  const key = `${group}.${value}`;
  return has(key) ? t(key) : String(value);
};

const tag = () => (language === "zh" ? "zh-CN" : "en");

export function number(value, digits = 1) {
  if (!Number.isFinite(value)) return "–";
  const format = { minimumFractionDigits: digits, maximumFractionDigits: digits, signDisplay: "negative" };
  return new Intl.NumberFormat(tag(), format).format(value);
}

export const clock = (unixSeconds) =>
  new Intl.DateTimeFormat(tag(), { hour: "2-digit", minute: "2-digit", second: "2-digit", hour12: false }).format(
    new Date(unixSeconds * 1000),
  );

export function bytes(count) {
  if (!Number.isFinite(count)) return "–";
  if (count < 1e6) return `${number(count / 1e3, count < 1e4 ? 1 : 0)} kB`;
  if (count < 1e9) return `${number(count / 1e6, 1)} MB`;
  return `${number(count / 1e9, 2)} GB`;
}

export const inDegrees = (radians) => (radians * 180) / Math.PI;

// A heading in whole degrees, -179 to 180.
export const degrees = (radians) => {
  const value = Math.round(inDegrees(radians)) % 360;
  return value > 180 ? value - 360 : value <= -180 ? value + 360 : value;
};

// Whether what `owner` shows has changed since the last call, or the language: only then is it built again.
export function changed(owner, ...shown) {
  const before = owner.shown;
  owner.shown = JSON.stringify([language, ...shown]);
  return owner.shown !== before;
}

// Texts of index.html: data-t is the text, data-t-label the accessible name.
export function relabel(root = document) {
  for (const element of root.querySelectorAll("[data-t]")) element.textContent = t(element.dataset.t);
  for (const element of root.querySelectorAll("[data-t-label]")) {
    element.setAttribute("aria-label", t(element.dataset.tLabel));
    if (element.tagName === "BUTTON") element.title = t(element.dataset.tLabel);
  }
}
