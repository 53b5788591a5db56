"""A blocking WebSocket client for tests, with TLS, too."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine, Iterator
from concurrent.futures import TimeoutError as Late
from typing import Any

import pytest

__all__ = ["connect"]

MISSING = 'websockets is not installed: pip install ".[bridge]"'


def connect(url: str, **options: Any) -> Any:
    """Connect as `websockets.sync.client.connect` does; the connection ends its `with` block.

    That client reads and writes in two threads, and before CPython 3.13 an SSL object loses data by it: on a busy
    computer one request in 400 never arrived, at a server of `websockets` itself as well. With TLS, one thread with an
    asyncio client does both.
    """
    if "ssl" in options:
        return TlsConnection(url, **options)
    return pytest.importorskip("websockets.sync.client", reason=MISSING).connect(url, **options)


class TlsConnection:
    """The part of the library's blocking connection that tests use; safe from any thread."""

    def __init__(self, url: str, **options: Any) -> None:
        client = pytest.importorskip("websockets.asyncio.client", reason=MISSING)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

        async def connected() -> Any:
            return await client.connect(url, **options)

        try:
            self._connection = self._do(connected())
        except BaseException:
            self._end()
            raise

    def _do(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(60.0)

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10.0)
        self._loop.close()

    def __enter__(self) -> TlsConnection:
        return self

    def __exit__(self, *_: object) -> None:
        self._do(self._connection.close())
        self._end()

    @property
    def close_code(self) -> int | None:
        code: int | None = self._connection.close_code
        return code

    def send(self, data: str | bytes) -> None:
        self._do(self._connection.send(data))

    def recv(self, timeout: float | None = None) -> str | bytes:
        try:
            data: str | bytes = self._do(asyncio.wait_for(self._connection.recv(), timeout))
        except (Late, asyncio.TimeoutError):
            raise TimeoutError from None
        return data

    def __iter__(self) -> Iterator[str | bytes]:
        from websockets.exceptions import ConnectionClosedOK

        try:
            while True:
                yield self.recv(60.0)
        except ConnectionClosedOK:
            return
