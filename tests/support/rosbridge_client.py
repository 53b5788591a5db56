"""A rosbridge client for tests: JSON over `websockets`, every wait with a deadline."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from tests.support.websocket import connect

SECONDS = 20.0


class RosbridgeClient:
    """One connection; close it, or use it in a `with` block."""

    def __init__(self, url: str, **options: Any) -> None:
        self._stack = ExitStack()
        connecting = connect(
            url, open_timeout=SECONDS, close_timeout=2, compression=None, max_size=None, **options
        )
        self._ws = self._stack.enter_context(connecting)

    @property
    def socket(self) -> Any:
        return self._ws.socket

    def send(self, **message: Any) -> None:
        self._ws.send(json.dumps(message))

    def send_raw(self, data: str | bytes) -> None:
        self._ws.send(data)

    def raw(self, timeout: float = SECONDS) -> str | bytes:
        data: str | bytes = self._ws.recv(timeout=timeout)
        return data

    def get(self, timeout: float = SECONDS) -> Any:
        """The next text message."""
        while isinstance(data := self.raw(timeout), bytes):
            pass
        return json.loads(data)

    def until(self, wanted: Callable[[Any], bool], timeout: float = SECONDS) -> Any:
        """Return the first wanted message; skip the others."""
        while not wanted(message := self.get(timeout)):
            pass
        return message

    def op(self, op: str, timeout: float = SECONDS) -> Any:
        """The next message of an operation."""
        return self.until(lambda message: message["op"] == op, timeout)

    def call(self, service: str, args: Any = None, id: str = "call") -> Any:
        """Call a service; the whole answer."""
        self.send(op="call_service", service=service, args=args, id=id)
        return self.until(lambda m: m["op"] == "service_response" and m.get("id") == id)

    def closed(self, timeout: float = SECONDS) -> tuple[int, str]:
        """Return code and reason of the server's close; skip earlier messages."""
        from websockets.exceptions import ConnectionClosed

        end: Any = None
        while end is None:
            try:
                self.raw(timeout)
            except ConnectionClosed as closed:
                end = closed
        return end.rcvd.code, end.rcvd.reason

    def abort(self) -> None:
        """Abort the connection without a closing handshake."""
        self._ws.socket.close()
        self.close()

    def close(self) -> None:
        self._stack.close()

    def __enter__(self) -> RosbridgeClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
