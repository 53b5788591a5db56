"""`Webhook`: sends the notices of missions to a URL, in order, until each has been taken.

Only the person who starts the program names the URL; a mission file cannot. What was taken is kept with the
state of the missions, so a restart goes on where it was. Redirects are not followed.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import threading
from collections.abc import Callable
from dataclasses import asdict
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from urllib.parse import urlsplit

from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.missions.machine import Notice, State

_log = get_logger("woosh_pure.missions.webhooks")
KINDS = ("start", "step", "question", "end")
_SECONDS, _PAUSES = 10.0, (1.0, 2.0, 5.0, 15.0, 60.0)


class Webhook:
    """Posts JSON with the headers `Webhook-Id` and `Webhook-Signature: sha256=...`, the HMAC of the body.

    Args:
        url: http:// or https://.
        secret: Key of the signature, at least 8 characters.
        state: Called for the newest state.
        delivered: Called with the `number` of the last notice that was taken.

    Raises:
        ValueError: The URL or the secret is not one.
    """

    def __init__(
        self, url: str, secret: str, state: Callable[[], State], delivered: Callable[..., object]
    ) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(say("webhook {url}: expected http://HOST/... or https://HOST/...", url=url))
        if len(secret) < 8:
            raise ValueError("a webhook needs a secret of at least 8 characters: set WOOSH_WEBHOOK_SECRET")
        self._parts, self._secret, self._state, self._delivered = parts, secret.encode(), state, delivered
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._work, name="woosh:webhook", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End; what was not taken is sent after the next start."""
        self._closed.set()
        self._thread.join(_SECONDS + 1.0)

    def _work(self) -> None:
        done, failures = self._state().delivered, 0
        while not self._closed.wait(_PAUSES[min(failures, len(_PAUSES)) - 1] if failures else 0.1):
            for notice in self._state().notices:
                if notice.number <= done or self._closed.is_set():
                    continue
                if notice.kind in KINDS and (problem := self._post(notice)):
                    failures += 1
                    _log.warning("! webhook %s: %s; tried again", self._parts.hostname, problem)
                    break
                done, failures = notice.number, 0
                self._delivered(number=done)

    def _post(self, notice: Notice) -> str:
        """Send one; "" if it was taken."""
        body = json.dumps(asdict(notice), ensure_ascii=False).encode()
        signature = hmac.new(self._secret, body, hashlib.sha256).hexdigest()
        headers = {
            "Content-Type": "application/json",
            "Webhook-Id": f"{notice.at:.3f}-{notice.number}",
            "Webhook-Signature": f"sha256={signature}",
        }
        kind = HTTPSConnection if self._parts.scheme == "https" else HTTPConnection
        link = kind(str(self._parts.hostname), self._parts.port, timeout=_SECONDS)
        path = (self._parts.path or "/") + (f"?{self._parts.query}" if self._parts.query else "")
        try:
            link.request("POST", path, body, headers)
            status = link.getresponse().status
        except (OSError, HTTPException) as error:
            return f"{type(error).__name__}: {error}"
        finally:
            link.close()
        return "" if 200 <= status < 300 else f"HTTP {status}"
