import assert from "node:assert/strict";
import { test } from "node:test";

import { use } from "../../../woosh_pure/web/page/js/i18n.js";
import { kindOf } from "../../../woosh_pure/web/page/js/server_values.js";
import { verdict } from "../../../woosh_pure/web/page/js/pose_confirmation.js";
import { blocking, briefText, causeText, distinct, endText, refusalText, stopText, whyOf } from "../../../woosh_pure/web/page/js/reason_words.js";

const EMERGENCY = { key: "emergency_stop", text: "emergency stop button (110201000013)", values: {}, blocking: true, doubt: false };
const WORDS = { english: "motor overheated", chinese: "电机过热" };
const FAULT = { key: "fault", text: "motor overheated (110301000013)", values: { words: WORDS, code: 110301000013 }, blocking: true, doubt: false };
const BUSY = { key: "busy", text: "our own task 1286666406 is running", values: { id: 1286666406 }, blocking: false, doubt: false };
const JARGON = /robot_state|\/robot_status|register|\d{5}|rad\b|\(\)/;

test("the cause comes first, in the language of the page, and what to do about it", () => {
  use("en");
  assert.match(causeText([EMERGENCY, FAULT]), /^The emergency stop is pressed\. What to do: /);
  assert.equal(whyOf(FAULT), "It reports: motor overheated.");
  use("zh");
  assert.match(causeText([EMERGENCY, FAULT]), /^急停已按下。/);
  assert.equal(whyOf(FAULT), "机器人报告：电机过热。");
  use("en");
});

test("what may be over is said to be so; what is not known is no such doubt", () => {
  assert.match(whyOf({ ...EMERGENCY, blocking: false, doubt: true }), /may be over\.$/);
  assert.equal(whyOf({ key: "unknown", doubt: true }), "It has not reported its state yet.");
});

test("each reason is said once, and a task of one's own is none", () => {
  assert.equal(distinct([EMERGENCY, EMERGENCY, BUSY]).length, 2);
  assert.deepEqual(blocking([BUSY, EMERGENCY, { ...BUSY, blocking: true }]), [EMERGENCY]);
});

test("a refusal says its cause, else the robot's own words, else its kind, else what came", () => {
  const problem = { type: "urn:woosh:motion-refused", detail: "pick task 1286666406 refused", reasons: [EMERGENCY] };
  assert.doesNotMatch(refusalText(problem, 409), JARGON);
  assert.match(refusalText(problem, 409), /^The emergency stop/);
  const said = { text: "no such mark", text_zh: "没有这个标记点" };
  assert.equal(refusalText({ ...problem, reasons: [BUSY], said }, 409), "The robot refused: “no such mark”");
  const lost = { key: "not_localised", text: "lost", blocking: false, doubt: false };
  assert.match(refusalText({ ...problem, reasons: [lost], said }, 409), /“no such mark” What to do: Tell it where it is/);
  assert.match(refusalText({ ...problem, reasons: [] }, 409), /^It was not started/);
  assert.match(refusalText({ type: "urn:woosh:leased", holder: "page 2 at 10.0.0.7" }, 409), /^page 2 \(10\.0\.0\.7\) has control/);
  assert.equal(refusalText({ type: "urn:woosh:new", detail: "as it came" }, 409), "as it came");
  assert.equal(refusalText({}, 418), "The server refused: 418");
});

test("an end that is bad says why, and whether the robot stands still", () => {
  const end = (state, more) => ({ kind: kindOf(state), reasons: [], said: null, stands_still: true, ...more });
  assert.match(endText(end("failed", { reasons: [EMERGENCY] })), /^At that time: The emergency stop is pressed\. It stood still\.$/);
  assert.match(endText(end("failed", { said: { text: "blocked" }, stands_still: false })), /^At that time: blocked THE ROBOT IS STILL MOVING/);
  assert.match(endText(end("connection lost", { stands_still: null })), /not known\. Watch it\.$/);
  assert.equal(endText(end("cancelled")), "");
  assert.match(endText(end("cancelled", { stands_still: false })), /STILL MOVING/);
  assert.equal(briefText(end("failed", { reasons: [EMERGENCY, FAULT] })), "The emergency stop is pressed.");
  assert.equal(briefText(end("arrived")), "");
});

test("what a stop has done is said without names of tasks and services", () => {
  const report = { cancelled: ["pick task 1286666406 to A1"], problems: ["registerPublisher: no answer"], pending: ["x"], looked: true };
  assert.doesNotMatch(stopText(report), JARGON);
  assert.match(stopText(report), /was cancelled\. Not everything .* repeated every second/);
  assert.equal(stopText({ looked: true }), "Nothing was under way.");
  assert.equal(stopText({ looked: false }), "");
});

test("a pose is taken when the robot says that it is there, or has found itself again", () => {
  const told = { x: 1, y: 2, yaw: 3.1 };
  const found = { lostBefore: false, lostNow: false };
  assert.equal(verdict(told, { x: 1.1, y: 2, yaw: -3.1 }, found).taken, true, "across the turn");
  assert.equal(verdict(told, { x: 1.6, y: 2, yaw: 3.1 }, found).taken, false);
  assert.equal(verdict(told, { x: 1, y: 2, yaw: 1 }, found).taken, false);
  assert.equal(verdict(told, told, { lostBefore: true, lostNow: true }).taken, false, "it says that it is lost");
  assert.equal(verdict(told, { x: 1.6, y: 2, yaw: 3.1 }, { lostBefore: true, lostNow: false }).taken, true);
});
