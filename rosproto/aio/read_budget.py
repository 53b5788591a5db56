"""`ReadBudget` and `BudgetedProtocol`: what a client sends takes a bounded part of a loop's time.

asyncio passes up to 256 KiB at once to a protocol. Forty thousand tiny frames fit into that, and a library
written in Python parses them for half a second, in which the loop serves nobody else. A `BudgetedProtocol`
stands between the transport and the library's protocol. It passes the bytes on in small pieces, within a
budget that all connections of a loop share. While bytes of a connection wait, its transport is paused
(`Transport.pause_reading`), so TCP slows its client down.

Parsing takes at most `turn` seconds of processor time and one piece (20 ms, if large) before the loop goes
on, and `share` of its time in the long run. Connections that wait are served by start-time fair queueing
(Goyal, Vin and Cheng 1996): one that sends little comes before those that flood.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from operator import attrgetter
from typing import Any

SMALL, LARGE = 1 << 10, 16 << 10
"""Bytes of a piece: few at first (of the smallest frames a millisecond), and twice as many after each piece
that was parsed in `QUICK` seconds, as those of long messages are."""
QUICK = 0.0005
FREE, FREE_BYTE = 1e-3, 1e-7
"""Seconds of parsing that do not count as overhead: in each second, for the pongs of a client that sends
nothing else for weeks; and for each byte, for long messages."""
_START = attrgetter("start")


class ReadBudget:
    """The budget of the connections of one loop. Used in the loop only.

    Args:
        cut_off: Called with the transport of a connection before it is aborted because it floods.
        share: Part of the loop's time for parsing.
        turn: Seconds of parsing without a pause.
        overhead: Seconds of parsing without a message (control frames, frames of a closed connection) after
            which a connection is aborted.
    """

    def __init__(
        self,
        cut_off: Callable[[asyncio.Transport], object],
        *,
        share: float = 0.5,
        turn: float = 0.005,
        overhead: float = 0.5,
    ) -> None:
        self._cut_off = cut_off
        self._turn, self._max_overhead = turn, overhead
        self._refill = share / (1.0 - share)  # seconds of a turn in a second without parsing
        self._waiting: dict[BudgetedProtocol, None] = {}  # in the order of their coming
        self._virtual = 0.0  # time of fair queueing: `start` of the connection that was served last
        self._spent = self._at = 0.0  # seconds of the turn, at this time
        self._scheduled: asyncio.Handle | None = None

    def begin(self, connection: BudgetedProtocol) -> None:
        """A connection was made: it does not come before those that are there."""
        connection.start = self._virtual

    def ask(self, connection: BudgetedProtocol, *, later: bool = False) -> None:
        """A connection has bytes to parse.

        Args:
            connection: It is served now, or when the turn of others is over.
            later: Not now: its protocol does not expect to be called.
        """
        if connection in self._waiting:
            return
        # One that took little is a turn ahead of those that always wait, not level with all of them.
        connection.start = max(connection.start, self._virtual - self._turn)
        self._waiting[connection] = None
        if self._scheduled is None:
            if later:
                self._schedule(0.0)
            else:
                self._parse()

    def forget(self, connection: BudgetedProtocol) -> None:
        """A connection has nothing to parse any more."""
        self._waiting.pop(connection, None)

    def _schedule(self, seconds: float) -> None:
        loop = asyncio.get_running_loop()
        if seconds:
            self._scheduled = loop.call_later(seconds, self._begin_turn)
        else:
            self._scheduled = loop.call_soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._scheduled = None
        self._parse()

    def _parse(self) -> None:
        """Parse pieces until the turn is over, or nothing waits."""
        now, used = time.monotonic(), time.thread_time()
        self._spent = max(0.0, self._spent - self._refill * (now - self._at))
        while self._waiting and self._spent < self._turn:
            connection = min(self._waiting, key=_START)
            self._virtual = max(self._virtual, connection.start)
            size = connection.piece
            more = connection.parse(size)
            before, used = used, time.thread_time()
            took = used - before
            self._spent += took
            connection.start += took
            connection.piece = min(2 * size, LARGE) if took < QUICK else SMALL
            free = FREE * (now - connection.at) + FREE_BYTE * size
            connection.overhead = max(0.0, connection.overhead + took - free)
            connection.at = now
            if not more:
                self.forget(connection)
            if connection.overhead > self._max_overhead and not connection.transport.is_closing():
                self._cut_off(connection.transport)
                connection.transport.abort()
                self.forget(connection)
        self._at = time.monotonic()
        if self._waiting and self._scheduled is None:
            self._schedule(self._spent / self._refill)


class BudgetedProtocol(asyncio.Protocol):
    """Passes what a transport receives on to a protocol, within a budget.

    Args:
        budget: The loop's.
        protocol: A library's; it gets a transport that it can use as any other one.

    Attributes:
        transport: The one below.
        start, piece: For `ReadBudget`: start tag and size of its next piece.
        overhead, at: For `ReadBudget`: seconds of parsing since its last message, at this time.
    """

    def __init__(self, budget: ReadBudget, protocol: Any) -> None:
        self.protocol = protocol
        self.transport: Any = None
        self.start = self.overhead = self.at = 0.0
        self.piece = SMALL
        self._budget = budget
        self._bytes, self._next = b"", 0  # received ones, and how many are parsed
        self._is_paused = False  # by its protocol
        self._is_read = True

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """See asyncio."""
        self.transport = transport
        self._budget.begin(self)
        self.protocol.connection_made(_PausableTransport(transport, self))

    def connection_lost(self, exc: Exception | None) -> None:
        """See asyncio."""
        self._drop()
        self.protocol.connection_lost(exc)

    def eof_received(self) -> bool | None:
        """See asyncio."""
        keep: bool | None = self.protocol.eof_received()
        return keep

    def pause_writing(self) -> None:
        """See asyncio."""
        self.protocol.pause_writing()

    def resume_writing(self) -> None:
        """See asyncio."""
        self.protocol.resume_writing()

    def data_received(self, data: bytes) -> None:
        """See asyncio."""
        # Earlier bytes are left if the transport does not pause at once (TLS up to Python 3.10).
        self._bytes, self._next = self._bytes[self._next :] + data if self._bytes else data, 0
        if not self._is_paused:
            self._budget.ask(self)
        self._read_or_pause()

    def parse(self, size: int) -> bool:
        """Parse `size` bytes; return whether there is more to parse."""
        begin, self._next = self._next, self._next + size
        piece = self._bytes[begin : self._next]
        if self._next >= len(self._bytes):
            self._bytes, self._next = b"", 0
        try:
            self.protocol.data_received(piece)
        except Exception as error:  # as asyncio does; but it is another connection's call
            asyncio.get_running_loop().call_exception_handler(
                {"message": "data_received failed", "exception": error, "transport": self.transport}
            )
            self.transport.abort()
        if self.transport.is_closing():
            self._drop()  # asyncio reads no more of it, either
        self._read_or_pause()
        return bool(self._bytes) and not self._is_paused

    def pause(self, paused: bool) -> None:
        """Its protocol takes bytes, or does not: for the first it has a message."""
        self._is_paused = paused
        if paused:
            self.overhead = 0.0
            self._budget.forget(self)
        elif self._bytes:
            self._budget.ask(self, later=True)
        self._read_or_pause()

    def replace(self, protocol: asyncio.Protocol) -> None:
        """Another protocol takes over; bytes that were sent before are dropped."""
        self._drop()
        self.protocol = protocol

    def _drop(self) -> None:
        self._bytes, self._next = b"", 0
        self._budget.forget(self)

    def _read_or_pause(self) -> None:
        wanted = not self._is_paused and not self._bytes
        if wanted is not self._is_read:
            self._is_read = wanted
            if wanted:
                self.transport.resume_reading()
            else:
                self.transport.pause_reading()


class _PausableTransport:
    """A transport as the protocol of a `BudgetedProtocol` sees it."""

    def __init__(self, transport: Any, protocol: BudgetedProtocol) -> None:
        self._transport, self._protocol = transport, protocol
        self.write, self.is_closing = transport.write, transport.is_closing  # used for each message

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    def pause_reading(self) -> None:
        """See asyncio."""
        self._protocol.pause(True)

    def resume_reading(self) -> None:
        """See asyncio."""
        self._protocol.pause(False)

    def set_protocol(self, protocol: asyncio.Protocol) -> None:
        """See asyncio."""
        self._protocol.replace(protocol)

    def get_protocol(self) -> asyncio.Protocol:
        """See asyncio."""
        protocol: asyncio.Protocol = self._protocol.protocol
        return protocol
