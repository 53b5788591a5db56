"""A client of the Robot API over WebSocket, which keeps the pushes that come between answers."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Mapping
from contextlib import ExitStack
from types import TracebackType
from typing import Any

from tests.support.websocket import connect

__all__ = ["ApiClient"]


class ApiClient:
    """One connection; use it in a `with` block.

    Attributes:
        pushes: Frames that answered nothing, in order.
    """

    def __init__(self, url: str, **options: Any) -> None:
        self.pushes: list[dict[str, Any]] = []
        self._numbers = itertools.count(1)
        self._stack = ExitStack()
        self._socket = self._stack.enter_context(connect(url, max_size=None, **options))

    def __enter__(self) -> ApiClient:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def close_socket(self) -> None:
        """End the connection without a word."""
        self._socket.close_socket()

    def send(self, frame: object) -> None:
        """Send a frame; a text or bytes as they are."""
        self._socket.send(frame if isinstance(frame, (str, bytes)) else json.dumps(frame))

    def receive(self, timeout: float = 20.0) -> dict[str, Any]:
        """The next frame."""
        frame: dict[str, Any] = json.loads(self._socket.recv(timeout))
        return frame

    def answer(self, frame: object, timeout: float = 20.0) -> dict[str, Any]:
        """Send a frame and return the next answer."""
        self.send(frame)
        while True:
            got = self.receive(timeout)
            if "ok" in got:
                return got
            self.pushes.append(got)

    def ask(self, kind: str, body: Mapping[str, object] | None = None) -> dict[str, Any]:
        """The body of the answer to a request, which must be accepted and have its number."""
        number = next(self._numbers)
        got = self.answer({"type": kind, "body": body or {}, "sn": number})
        assert got["ok"], got["msg"]
        assert got["sn"] == number
        body_got: dict[str, Any] = got["body"]
        return body_got

    def subscribe(self, *topics: str, sub: bool = True) -> None:
        """Begin or end pushes; there is no answer."""
        self.send({"type": "woosh.Subscription", "body": {"sub": sub, "topics": topics}})

    def next_push(self, kind: str, timeout: float = 20.0) -> dict[str, Any]:
        """The body of the next push of a type; others before it are left out."""
        end = time.monotonic() + timeout
        while True:
            frame = self.pushes.pop(0) if self.pushes else self.receive(max(0.01, end - time.monotonic()))
            if frame["type"] == kind:
                body: dict[str, Any] = frame["body"]
                return body

    def pushed_within(self, seconds: float) -> list[dict[str, Any]]:
        """The frames that come within some seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            try:
                self.pushes.append(self.receive(left))
            except TimeoutError:
                break
        found, self.pushes = self.pushes, []
        return found
