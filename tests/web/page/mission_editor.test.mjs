import assert from "node:assert/strict";
import { test } from "node:test";

import { typed } from "../../../woosh_pure/web/page/js/mission_editor.js";

test("what is typed becomes what the file has", () => {
  assert.equal(typed("number", "0.5"), 0.5);
  assert.equal(typed("whole", "3"), 3);
  assert.equal(typed("number", "$angle"), "$angle", "a parameter");
  assert.equal(typed("number", "far"), "far", "the server says what is wrong");
  assert.equal(typed("bool", "false"), false);
  assert.equal(typed("mark", "12"), "12", "a mark may be called so");
  assert.equal(typed("text", "true"), "true");
});
