"""One WebSocket connection of the library `websockets`, adapted to the gateway's server.

Its events are reported to the server, what it writes is bounded, and so are the fragments of a message read.
"""

from __future__ import annotations

from typing import Any, Protocol

WRITE_BUFFER = 256 << 10  # bytes given to the system's socket ahead of what it took
FRAGMENTS = 4096
"""Of one message. Empty ones cost memory too, which no limit of bytes sees; `websockets` counts them itself
from 17.4 on, which needs Python 3.11."""


class ConnectionEvents(Protocol):
    """The server, as its connections report to it; called in the loop."""

    def connected(self, connection: Any, transport: Any) -> None: ...

    def disconnected(self, connection: Any, error: Exception | None) -> None: ...

    def write_paused(self, connection: Any) -> None: ...

    def write_resumed(self, connection: Any) -> None: ...


async def read_message(connection: Any) -> str | bytes | None:
    """The next message of a client; None if it has more than `FRAGMENTS` fragments."""
    fragments: list[Any] = []
    async for fragment in connection.recv_streaming():
        if len(fragments) == FRAGMENTS:
            return None
        fragments.append(fragment)
    whole: str | bytes = fragments[0] if len(fragments) == 1 else type(fragments[0])().join(fragments)
    return whole


def connection_type(base: Any, events: ConnectionEvents, most_unsent: int) -> Any:
    """A subclass of the library's connection class that reports to the server.

    Args:
        base: `websockets.asyncio.server.ServerConnection`.
        events: The server.
        most_unsent: Bytes that may wait in a connection's transport; beyond that it is aborted.
    """

    def connection_made(self: Any, transport: Any) -> None:
        transport = _Transport(transport, most_unsent)
        base.connection_made(self, transport)
        events.connected(self, transport)

    def connection_lost(self: Any, error: Exception | None) -> None:
        events.disconnected(self, error)
        base.connection_lost(self, error)

    def pause_writing(self: Any) -> None:
        base.pause_writing(self)
        events.write_paused(self)

    def resume_writing(self: Any) -> None:
        base.resume_writing(self)
        events.write_resumed(self)

    own = connection_made, connection_lost, pause_writing, resume_writing
    return type("Connection", (base,), {each.__name__: each for each in own})


class _Transport:
    """A client's transport that drops what is written while it closes, and is aborted above `most` bytes.

    Before `connection_lost` the library goes on writing, and asyncio would log each of 40,000 pongs.
    """

    def __init__(self, transport: Any, most: int) -> None:
        self._transport, self._most = transport, most

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    def write(self, data: Any) -> None:
        """Write; while the transport closes, drop the data."""
        if self._transport.get_write_buffer_size() > self._most:
            self._transport.abort()
        if not self._transport.is_closing():
            self._transport.write(data)


def peer_of(connection: Any) -> str:
    """ "10.0.0.7:51234"; "?" if it is unknown."""
    address = connection.remote_address
    return f"{address[0]}:{address[1]}" if address else "?"
