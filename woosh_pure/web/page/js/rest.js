// Calls of the REST API, each with a time-out. An error has words for the reason.

import { collect } from "./response_body.js";
import { current, t } from "./i18n.js";
import { refusalText } from "./reason_words.js";

export class Refused extends Error {
  constructor(text, status = 0, problem = {}) {
    super(text);
    this.status = status;
    this.problem = problem;
  }
}

export class Rest {
  constructor(base, { fetch = globalThis.fetch.bind(globalThis), onToken = () => {} } = {}) {
    this.base = base;
    this.fetch = fetch;
    this.onToken = onToken;
    this.session = null;
    this.logins = 0; // accepted ones
  }

  // The token becomes a cookie that no script can read. Null when it was accepted, else the reason.
  login(token) {
    return this.call("POST", "login", { token }).then(() => (this.logins++, null), (error) => error.message);
  }

  async call(method, path, body = null, { timeout = 10, session = true, headers: more = {} } = {}) {
    const headers = { "Accept-Language": current(), ...more };
    const { logins } = this;
    if (this.session && session) headers["X-Woosh-Session"] = this.session;
    if (body !== null) headers["Content-Type"] = "application/json";
    const ending = new AbortController();
    const timer = setTimeout(() => ending.abort(), timeout * 1000);
    try {
      const answer = await this.fetch(this.base + path, {
        method, headers, body: body === null ? undefined : JSON.stringify(body), signal: ending.signal,
      });
      if (!answer.ok) throw await this.refusal(answer, logins);
      return answer;
    } catch (error) {
      if (error instanceof Refused) throw error;
      if (ending.signal.aborted) throw new Refused(t("error.timeout", { n: timeout }));
      throw new Refused(t("error.offline"));
    } finally {
      clearTimeout(timer);
    }
  }

  // A call from before the last login says nothing about its token.
  async refusal(answer, logins) {
    const problem = await answer.json().catch(() => ({}));
    if (answer.status === 401 && logins === this.logins && !answer.url.endsWith("/login")) this.onToken();
    return new Refused(refusalText(problem, answer.status), answer.status, problem);
  }

  async json(method, path, body = null, options = {}) {
    const answer = await this.call(method, path, body, options);
    const text = await answer.text();
    return text ? JSON.parse(text) : null;
  }

  // Fetch a picture or file; onProgress(part, size, total) reports the progress, `signal` cancels.
  async blob(path, onProgress = () => {}, signal = null) {
    const answer = await this.call("GET", path, null, { timeout: 30 });
    const stalled = () => new Refused(t("error.stalled"));
    try {
      return await collect(answer, onProgress, { stalled, signal });
    } catch (error) {
      throw error instanceof Refused ? error : stalled(); // the connection broke, or was cancelled
    }
  }
}
