// When a refused call asks for the token.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Rest } from "../../../woosh_pure/web/page/js/rest.js";

const answer = (status, url) => ({ ok: status < 400, status, url, json: () => Promise.resolve({}) });

test("a refused call asks for the token", async () => {
  let asked = 0;
  const rest = new Rest("/", { fetch: (url) => Promise.resolve(answer(401, url)), onToken: () => asked++ });
  await assert.rejects(rest.call("GET", "status"));
  assert.equal(asked, 1);
  assert.notEqual(await rest.login("a guess"), null);
  assert.equal(asked, 1); // the dialog says why itself
});

test("a call that was begun before the token was accepted does not ask again when it is refused", async () => {
  let asked = 0;
  const held = [];
  const fetch = (url) => (url.endsWith("login") ? Promise.resolve(answer(204, url)) : new Promise((done) => held.push(() => done(answer(401, url)))));
  const rest = new Rest("/", { fetch, onToken: () => asked++ });
  const early = rest.call("GET", "status");
  assert.equal(await rest.login("right"), null);
  held.pop()();
  await assert.rejects(early);
  assert.equal(asked, 0);
  const later = rest.call("GET", "status"); // the server has another token by now
  held.pop()();
  await assert.rejects(later);
  assert.equal(asked, 1);
});
