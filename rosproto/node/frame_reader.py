"""From a connected socket to decoded messages, with as few system calls and as little copying as possible.

A large buffer takes whatever has arrived; every frame in it is decoded in place. A frame that is too long for
that gets memory of its own and is received straight into it. Each system call gives the interpreter away and
may wait for it to come back (5 ms when another thread computes), so their number decides (performance.md,
sections 3 and 5).

Source: wiki.ros.org/ROS/TCPROS (framing).
"""

from __future__ import annotations

import socket
import struct
import sys
from collections.abc import Callable
from typing import Any, Protocol

from rosproto.errors import ConnectionLost, TooLarge

__all__ = ["FrameReader"]

FIRST_BUFFER = 4 << 10  # bytes; most topics never need more, and a node may have hundreds
BUFFER = 256 << 10  # what it grows to when reads fill it
LARGE = 128 << 10  # longer frames get their own memory
BATCH = 64  # messages decoded at a time: their memory is then used again, and the collector is not woken
STEP = 16 << 20  # memory follows the bytes that arrive, not the length announced (pitfall 10)

_length = struct.Struct("<I").unpack_from
# Windows' WAITALL fails on non-blocking sockets only, but it also waits for ever on a reset there: leave it.
_WAIT_ALL = getattr(socket, "MSG_WAITALL", 0) if sys.platform != "win32" else 0

Decode = Callable[[Any, int, int], Any]


class HasSink(Protocol):
    """A subscription, as far as reading goes."""

    sink: Any


class FrameReader:
    """Reads one connection; used by one thread.

    Attributes:
        bytes: Bytes received.
        messages: Messages cut out, those skipped included.
        skipped: Messages not decoded, because more of them had arrived than anybody keeps.
    """

    def __init__(self, sock: socket.socket, limit: int, *, peer: str = "") -> None:
        self._sock = sock
        self._limit = limit
        self._peer = peer
        self._buffer = bytearray(FIRST_BUFFER)
        self._view = memoryview(self._buffer)
        self._start = 0
        self._end = 0
        self.bytes = 0
        self.messages = 0
        self.skipped = 0

    def receive(self, decode: Decode, owns: bool, newest: int | None = None) -> list[Any]:
        """Wait until at least one message is complete; return all that are.

        Args:
            decode: `(buffer, start, end) -> message`.
            owns: True when messages keep parts of the buffer they are decoded from: they get one of their
                own.
            newest: Decode at most this many of what has arrived, the newest; None decodes all.

        Raises:
            ConnectionLost: The publisher closed the connection.
            TooLarge: A frame is longer than `limit`; the stream cannot go on.
            CodecError: A message does not fit its definition; the same.
            OSError: The connection broke.
        """
        if self._start == self._end:
            # Most often one read brings one message: it is decoded without looking for others.
            if self._end == len(self._buffer) < BUFFER:
                self._grow(0, 0)  # the last read filled it
            buffer = self._buffer
            end = self._sock.recv_into(buffer)
            if end > 4 and _length(buffer)[0] == end - 4:
                self._start = self._end = end
                self.bytes += end
                self.messages += 1
                if owns:
                    return [decode(bytes(self._view[4:end]), 0, end - 4)]
                return [decode(buffer, 4, end)]
            self._start = self._end = 0
            self._arrived(end)
        while True:
            batch = self._cut(decode, owns) if newest is None else self._cut_newest(decode, owns, newest)
            if batch:
                return batch
            size = self._pending_size()
            if size > LARGE:
                self.messages += 1
                return [self._receive_large(size, decode)]
            self._fill(size)

    def receive_singles(
        self,
        decode: Decode,
        owns: bool,
        take: Callable[[Any], object],
        header: dict[str, str],
        holder: HasSink,
    ) -> None:
        """Wait for messages that come alone, and hand each to `take`; return when anything else came.

        What came then waits for `receive`: several messages, a part of one, or one for another sink than the
        holder's when this was called. By far the most messages come alone, after a wait in which the
        processor's caches were used by others: every function and object on their way costs more there than
        it takes when it is called often (a round trip takes 3 to 7 % less time than by `receive`).

        Args:
            decode, owns: As for `receive`.
            take: Called with each message.
            header: Given to each as `_connection_header`.
            holder: Whose `sink` tells who is to get the messages.

        Raises:
            ConnectionLost, CodecError, OSError: As `receive`.
        """
        if self._start != self._end:
            return
        sink, buffer, view, recv_into = holder.sink, self._buffer, self._view, self._sock.recv_into
        room = len(buffer)
        while True:
            end = recv_into(buffer)
            if 3 < end < room and _length(buffer)[0] == end - 4 and holder.sink is sink:
                self.bytes += end
                self.messages += 1
                message = decode(bytes(view[4:end]), 0, end - 4) if owns else decode(buffer, 4, end)
                message._connection_header = header
                take(message)
            else:
                self._start = self._end = 0
                self._arrived(end)
                return

    def _cut(self, decode: Decode, owns: bool) -> list[Any]:
        buffer, start, end = self._buffer, self._start, self._end
        batch: list[Any] = []
        append = batch.append
        try:
            for _ in range(BATCH):
                if end - start < 4:
                    break
                following = start + 4 + _length(buffer, start)[0]
                if following > end:
                    break
                if owns:
                    append(decode(bytes(self._view[start + 4 : following]), 0, following - start - 4))
                else:
                    append(decode(buffer, start + 4, following))
                start = following
        finally:
            self._start = start
        self.messages += len(batch)
        return batch

    def _cut_newest(self, decode: Decode, owns: bool, newest: int) -> list[Any]:
        """As `_cut`, but the frames are found first and the older ones passed over."""
        buffer, start, end = self._buffer, self._start, self._end
        frames: list[tuple[int, int]] = []
        while end - start >= 4:
            following = start + 4 + _length(buffer, start)[0]
            if following > end:
                break
            frames.append((start + 4, following))
            start = following
        self._start = start
        self.messages += len(frames)
        self.skipped += max(0, len(frames) - newest)
        if owns:
            return [decode(bytes(self._view[a:b]), 0, b - a) for a, b in frames[-newest:]]
        return [decode(buffer, a, b) for a, b in frames[-newest:]]

    def _pending_size(self) -> int:
        """Length of the frame that is not complete; -1 while its length is not."""
        if self._end - self._start < 4:
            return -1
        size: int = _length(self._buffer, self._start)[0]
        if size > self._limit:
            raise TooLarge("message_bytes", size, self._limit)
        return size

    def _fill(self, size: int) -> None:
        """Read more; `size` is that of the frame that has begun, -1 while it is not known."""
        rest = self._end - self._start
        room = len(self._buffer)
        if size + 4 > room or (self._end == room < BUFFER):
            self._grow(size + 4, rest)
        elif not rest:
            self._start = self._end = 0
        elif room - self._end < room // 2:
            self._buffer[:rest] = self._buffer[self._start : self._end]
            self._start, self._end = 0, rest
        self._arrived(self._sock.recv_into(self._view[self._end :]))

    def _grow(self, size: int, rest: int) -> None:
        """A frame does not fit, or a read filled the buffer: a larger one, with the rest in front."""
        buffer = bytearray(min(max(4 * len(self._buffer), 2 * size), BUFFER))
        buffer[:rest] = self._view[self._start : self._end]
        self._buffer, self._view = buffer, memoryview(buffer)
        self._start, self._end = 0, rest

    def _arrived(self, count: int) -> None:
        if not count:
            raise self._ended(self._end - self._start)
        self.bytes += count
        self._end += count

    def _receive_large(self, size: int, decode: Decode) -> Any:
        """A frame in memory of its own, which the message keeps."""
        have = self._end - self._start - 4
        data = bytearray(max(STEP, have)) if size > STEP else _memory(size)
        data[:have] = self._view[self._start + 4 : self._end]
        self._start = self._end = 0
        while have < size:
            if have == len(data):
                data += bytes(min(len(data), size - have))
            with memoryview(data) as view:
                count = self._sock.recv_into(view[have:], 0, _WAIT_ALL)
            if not count:
                raise self._ended(have)
            self.bytes += count
            have += count
        return decode(data, 0, size)

    def _ended(self, left: int) -> ConnectionLost:
        inside = f" inside a message ({left} bytes of it arrived)" if left else ""
        return ConnectionLost(f"the publisher at {self._peer} closed the connection{inside}", peer=self._peer)


def _memory(size: int) -> Any:
    """Writable memory; numpy's where it is loaded, which is not filled with zeros first.

    The zeros are a quarter of a subscriber's time: 1.6 ms against 1.2 for 6.2 MB.
    """
    empty = getattr(sys.modules.get("numpy"), "empty", None)
    return bytearray(size) if empty is None else memoryview(empty(size, "u1"))
