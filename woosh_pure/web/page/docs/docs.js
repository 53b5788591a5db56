// The page of the API: shows this server's openapi.json. Needs no internet connection.

import { byId, el, fill } from "../js/dom.js";
import { zh } from "./words_zh.js";

const chinese = navigator.language.startsWith("zh");
const WORDS = chinese
  ? {
    answers: "应答", body: "请求体", name: "名称", optional: "可选", parameters: "参数", token: "这台服务器需要令牌：请先打开主页登录，再回到这里。",
    failed: "无法读取 openapi.json：", robots: "每个地址也可以写在 /api/v1/robots/名称/ 之下，用于指定某一台机器人。", page: "主页", deprecated: "旧名称", send: "试一试", moves: "这会让机器人移动。请确认路线畅通。发送吗？",
  }
  : {
    answers: "Answers", body: "Body", name: "Name", optional: "optional", parameters: "Parameters", token: "This server needs a token: open the page of the robot, sign in there, and come back.",
    failed: "openapi.json cannot be read: ", robots: "Each address is there below /api/v1/robots/NAME/ as well, for one robot of several.", page: "page of the robot", deprecated: "old name", send: "Try it", moves: "This moves the robot. Check that the way is clear. Send it?",
  };
const MOVES = new Set(["create_goal", "resume_goal", "create_run", "answer_run", "control_queue"]);
const STAYS = new Set(["pause", "stop", "clear"]);  // what control_queue does without moving anything
const said = (text) => (chinese && zh[text]) || text;
const SHOWN = ["get", "post", "put", "patch", "delete"];
const root = location.pathname.replace(/(\/robots\/[^/]+)?\/docs\/[^/]*$/, "");

let parts = {};
const resolved = (schema) => (schema.$ref ? parts[schema.$ref.split("/").pop()] : schema);
const kinds = (schema) => (schema.oneOf ?? schema.anyOf ?? [schema]).map(resolved);

// The allowed values: "number, -10 to 10".
function allowed(schema) {
  return kinds(schema).map((one) => {
    if (one.const !== undefined) return JSON.stringify(one.const);
    if (one.enum) return one.enum.map((each) => JSON.stringify(each)).join(", ");
    if (one.type === "array") return `[${allowed(one.items ?? {})}, ...]`;
    const low = one.minimum ?? (one.exclusiveMinimum === undefined ? undefined : `> ${one.exclusiveMinimum}`);
    const range = low === undefined || one.maximum === undefined ? "" : `, ${low} ... ${one.maximum}`;
    const letters = one.maxLength === undefined ? "" : `, ${one.minLength ?? 0} ... ${one.maxLength}`;
    return `${one.type ?? one.title ?? "any"}${range}${letters}`;
  }).join(" | ");
}

const about = (schema) => schema.description ?? kinds(schema).find((one) => one.description)?.description ?? "";

const row = (name, schema, required, text) => el("tr", {},
  el("th", { scope: "row" }, el("code", { class: schema.deprecated ? "deprecated" : null }, name)),
  el("td", {}, el("code", {}, allowed(schema))),
  el("td", {}, [schema.deprecated ? WORDS.deprecated : required ? "" : WORDS.optional, text].filter(Boolean).join("; ")));

const members = (schema) => el("table", {}, ...Object.entries(schema.properties ?? {}).map(([name, part]) =>
  row(name, part, schema.required?.includes(name), about(part))));

function example(schema) {
  const one = kinds(schema)[0];
  if (one.const !== undefined) return one.const;
  if (one.enum) return one.enum[0];
  if (one.examples) return one.examples[0];
  if (one.type !== "object") return { boolean: true, number: one.maximum ?? 1, integer: 1 }[one.type] ?? "text";
  return Object.fromEntries((one.required ?? []).map((name) => [name, example(one.properties[name])]));
}

function curl(method, path, operation, secret) {
  const body = operation.requestBody?.content["application/json"]?.schema;
  const words = ["curl", method === "get" ? "" : `-X ${method.toUpperCase()}`, secret ? "-H 'Authorization: Bearer TOKEN'" : ""];
  if (body) words.push(`-H 'content-type: application/json' -d '${JSON.stringify(example(body))}'`);
  return [...words, `'${location.origin}${root}${path}'`].filter(Boolean).join(" ");
}

function shape(operation) {
  const body = operation.requestBody?.content["application/json"]?.schema;
  return body ? [el("h3", {}, WORDS.body), ...kinds(body).flatMap((one) => [el("p", {}, one.description ?? ""), members(one)])] : [];
}

// Sends the request with the log-in of this browser; what moves the robot asks first.
function trial(path, method, operation) {
  const given = (operation.parameters ?? []).filter((one) => one.in !== "header").map((one) => [one, el("input", { id: `${operation.operationId}-${one.name}` })]);
  const schema = operation.requestBody?.content["application/json"]?.schema;
  const body = schema && el("textarea", { "aria-label": WORDS.body, rows: 6 });
  if (body) body.value = JSON.stringify(example(schema), null, 2);
  const shown = el("div", { "aria-live": "polite" });
  const send = async () => {
    const query = given.filter(([one, { value }]) => one.in === "query" && value).map(([one, { value }]) => `${one.name}=${encodeURIComponent(value)}`);
    const at = given.reduce((left, [one, { value }]) => left.replace(`{${one.name}}`, encodeURIComponent(value)), path);
    const answer = await fetch(`${root}${at}?${query.join("&")}`, {
      method: method.toUpperCase(), ...(body?.value ? { body: body.value, headers: { "content-type": "application/json" } } : {}),
    });
    const picture = answer.headers.get("content-type")?.startsWith("image/");
    const text = picture ? "" : await answer.text();
    fill(shown, el("pre", {}, `${answer.status} ${answer.headers.get("location") ?? ""}\n${text}`),
      picture ? el("img", { src: URL.createObjectURL(await answer.blob()), alt: at }) : null);
  };
  const onsubmit = (event) => {
    event.preventDefault();
    const moves = MOVES.has(operation.operationId) && !given.some(([, { value }]) => STAYS.has(value));
    if (moves && !confirm(WORDS.moves)) return;
    send().catch((error) => fill(shown, el("pre", {}, error.message)));
  };
  return el("form", { onsubmit }, ...given.map(([one, input]) => el("label", {}, el("span", {}, one.name), input)), body ?? "",
    el("button", {}, WORDS.send), shown);
}

function answers(operation) {
  return el("table", {}, ...Object.entries(operation.responses).map(([status, answer]) => {
    const schema = answer.content?.["application/json"]?.schema;
    const shown = schema && (schema.items ? [resolved(schema.items).title] : kinds(schema).map((one) => one.title)).filter(Boolean);
    return el("tr", {}, el("th", { scope: "row" }, el("code", {}, status)), el("td", {}, answer.description),
      el("td", {}, el("code", {}, shown?.join(" ") ?? Object.keys(answer.content ?? {}).join(" "))));
  }));
}

function operationOf(path, method, operation, secret) {
  const given = (operation.parameters ?? []).map((one) =>
    row(one.name, one.schema, one.required, [one.in, one.description].filter(Boolean).join(": ")));
  return el("details", { id: operation.operationId },
    el("summary", {}, el("strong", {}, el("code", {}, `${method.toUpperCase()} ${path}`)), ` ${operation.description ?? ""}`),
    el("pre", {}, curl(method, path, operation, secret)),
    path.endsWith("/stream") ? null : trial(path, method, operation),
    ...(given.length ? [el("h3", {}, WORDS.parameters), el("table", {}, ...given)] : []),
    ...shape(operation),
    el("h3", {}, WORDS.answers), answers(operation));
}

function written(described) {
  parts = described.components.schemas;
  const groups = new Map();
  for (const [path, item] of Object.entries(described.paths)) {
    if (path.includes("/robots/{robot}/")) continue;
    for (const method of SHOWN.filter((each) => each in item)) {
      const [group] = item[method].tags;
      const secret = (item[method].security ?? described.security ?? []).length > 0;
      groups.set(group, [...(groups.get(group) ?? []), operationOf(path, method, item[method], secret)]);
    }
  }
  return [
    el("p", {}, described.info.description), el("p", {}, WORDS.robots),
    el("p", {}, el("a", { href: `${root}/openapi.json` }, "openapi.json"), " · ", el("a", { href: "../" }, WORDS.page)),
    ...[...groups].flatMap(([group, all]) => [el("h2", {}, said(group)), ...all]),
  ];
}

async function main() {
  document.documentElement.lang = chinese ? "zh" : "en";
  const box = byId("api");
  try {
    const answer = await fetch(`${root}/openapi.json`);
    if (answer.status === 401) fill(box, el("p", {}, WORDS.token, " ", el("a", { href: "../" }, WORDS.page)));
    else if (answer.ok) fill(box, ...written(JSON.parse(await answer.text(), (key, value) => (key === "description" ? said(value) : value))));
    else fill(box, el("p", {}, `${WORDS.failed}${answer.status}`));
  } catch (error) {
    fill(box, el("p", {}, WORDS.failed + error.message));
  }
}

main();
