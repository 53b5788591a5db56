"""The proxy's connection to the SDK server of one client."""

from __future__ import annotations

import asyncio
from typing import Protocol, cast

from rosproto.gateway.foxglove import handshake

__all__ = ["Downstream", "UpstreamConnection"]


class Downstream(Protocol):
    """The client's end, as this connection uses it."""

    def write(self, data: bytes) -> None:
        """Send bytes to the client."""

    def reading(self, wanted: bool) -> None:
        """Go on reading from the client, or pause."""

    def finish(self) -> None:
        """The SDK server has hung up: send what is still waiting, then close."""


class UpstreamConnection(asyncio.Protocol):
    """Reads the SDK's answer to the handshake, then passes every byte to the client.

    Args:
        loop: The proxy's.
        client: The other end.

    Attributes:
        answer: The head of the SDK's answer, and the bytes that came after it.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, client: Downstream) -> None:
        self._client = client
        self._buffer = bytearray()
        self._transport: asyncio.Transport | None = None
        self.answer: asyncio.Future[tuple[bytes, bytes]] = loop.create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        if self.answer.done():
            self._client.write(data)
            return
        self._buffer += data
        place = self._buffer.find(handshake.HEAD_END)
        if place >= 0:
            self.reading(False)  # whatever follows waits until the client has its answer
            self.answer.set_result((bytes(self._buffer[: place + 4]), bytes(self._buffer[place + 4 :])))
            self._buffer.clear()

    def connection_lost(self, error: Exception | None) -> None:
        if not self.answer.done():
            self.answer.set_exception(ConnectionResetError("the SDK's server hung up"))
            self.answer.exception()  # perhaps nobody waits for it any more
        self._client.finish()

    @property
    def port(self) -> int:
        """Our own port of this connection."""
        assert self._transport is not None
        return int(self._transport.get_extra_info("sockname")[1])

    def write(self, data: bytes) -> None:
        """Send bytes to the SDK server."""
        if self._transport is not None:
            self._transport.write(data)

    def pause_writing(self) -> None:
        self._client.reading(False)

    def resume_writing(self) -> None:
        self._client.reading(True)

    def reading(self, wanted: bool) -> None:
        """Go on reading from the SDK server, or pause."""
        if self._transport is None or self._transport.is_closing():
            return
        if wanted:
            self._transport.resume_reading()
        else:
            self._transport.pause_reading()

    def end(self) -> None:
        """Cut the connection."""
        if self._transport is not None:
            self._transport.abort()
