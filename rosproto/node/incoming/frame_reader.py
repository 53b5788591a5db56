"""From a connected socket to decoded messages, with as few system calls and as little copying as possible.

`protocol.framing` cuts the stream; here its space is filled by a socket. Each system call gives the
interpreter away and may wait for it to come back (5 ms when another thread computes), so their number
decides (docs/performance.md).

Source: wiki.ros.org/ROS/TCPROS (framing).
"""

from __future__ import annotations

import socket
import struct
import sys
from collections.abc import Callable
from time import perf_counter, sleep
from typing import Any, Protocol

from rosproto.errors import ConnectionLost
from rosproto.protocol.framing import Decode, FrameDecoder

FIRST_BUFFER = 4 << 10  # bytes; most topics never need more, and a node may have hundreds

LOOK_AFTER = 32  # messages between two looks at the clock
CLOSE = 8e-6  # seconds between messages that are a burst; a round trip takes longer
REST = 100e-6  # seconds for which the connection is left alone in a burst, so that messages gather
ENOUGH = 16 << 10  # bytes: a read that brought as much needs no rest
NO_REST = 1.0  # seconds without rests when they last too long

_length = struct.Struct("<I").unpack_from
# Windows' WAITALL fails on non-blocking sockets only, but it also waits for ever on a reset there: leave it.
_WAIT_ALL = getattr(socket, "MSG_WAITALL", 0) if sys.platform != "win32" else 0


class HasSink(Protocol):
    """A subscription, as far as reading goes."""

    delivery: Any


class FrameReader:
    """Reads one connection; used by one thread.

    Attributes:
        bytes: Bytes received.
    """

    def __init__(self, sock: socket.socket, limit: int, *, peer: str = "") -> None:
        self._sock = sock
        self._peer = peer
        self._frames = FrameDecoder(limit, room=FIRST_BUFFER)
        self.bytes = 0
        self._looked = perf_counter()
        self._seen = 0  # messages then
        self._came = 0  # bytes of the last read
        self._long_rests = 0
        self._no_rest_until = 0.0

    @property
    def messages(self) -> int:
        """Messages cut out, those skipped included."""
        return self._frames.count

    @property
    def skipped(self) -> int:
        """Messages not decoded, because more of them had arrived than anybody keeps."""
        return self._frames.passed_over

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
        frames = self._frames
        if not frames.buffered:
            # Most often one read brings one message: it is decoded without looking for others.
            if frames.count - self._seen >= LOOK_AFTER:
                self._look()
            space = frames.space()
            end, buffer = self._sock.recv_into(space), frames.buffer
            if 4 < end < len(buffer) and _length(buffer)[0] == end - 4:
                self._came = end
                self.bytes += end
                frames.count += 1
                if owns:
                    return [decode(bytes(space[4:end]), 0, end - 4)]
                return [decode(buffer, 4, end)]
            self._arrived(end)
        while not (batch := frames.decoded(decode, owns, newest)):
            space = frames.space()
            self._arrived(self._sock.recv_into(space, 0, _WAIT_ALL if frames.is_large else 0))
        return batch

    def receive_singles(
        self,
        decode: Decode,
        owns: bool,
        take: Callable[[Any], object],
        header: dict[str, str],
        holder: HasSink,
    ) -> None:
        """Wait for messages that come alone, and hand each to `take`; return when anything else came.

        What came then waits for `receive`: several messages, a part of one, or one for another delivery than
        the holder's when this was called. By far the most messages come alone, after a wait in which the
        processor's caches were used by others: every function and object on their way costs more there than
        it takes when it is called often (a round trip takes 3 to 7 % less time than by `receive`).

        Args:
            decode, owns: As for `receive`.
            take: Called with each message.
            header: Given to each as `_connection_header`.
            holder: Whose `delivery` tells who is to get the messages.

        Raises:
            ConnectionLost, CodecError, OSError: As `receive`.
        """
        frames = self._frames
        if frames.buffered:
            return
        if frames.count - self._seen >= LOOK_AFTER:
            self._look()
        view, recv_into = frames.space(), self._sock.recv_into
        delivery, buffer = holder.delivery, frames.buffer
        room = len(buffer)
        while True:
            for _ in range(LOOK_AFTER):
                end = recv_into(buffer)
                if 3 < end < room and _length(buffer)[0] == end - 4 and holder.delivery is delivery:
                    self.bytes += end
                    frames.count += 1
                    message = decode(bytes(view[4:end]), 0, end - 4) if owns else decode(buffer, 4, end)
                    message._connection_header = header
                    take(message)
                else:
                    self._arrived(end)
                    return
            self._came = end
            self._look()

    def _look(self) -> None:
        """In a burst, let messages gather before the next read.

        Who writes each message alone (rospy) pays for waking a reader that waits, and the reader for being
        woken, several times what a message costs otherwise. So it is left alone for a moment.
        """
        now, count = perf_counter(), self._frames.count
        apart, self._looked, self._seen = (now - self._looked) / (count - self._seen), now, count
        if apart < CLOSE and self._came < ENOUGH and now >= self._no_rest_until:
            sleep(REST)
            self._rested(perf_counter() - now)

    def _rested(self, took: float) -> None:
        """Two rests in a row longer than a turn of the interpreter: another thread of this process computes.

        Then each rest is one more wait for the interpreter, and there is none for a while.
        """
        self._long_rests = self._long_rests + 1 if took > sys.getswitchinterval() else 0
        if self._long_rests > 1:
            self._no_rest_until = perf_counter() + NO_REST

    def _arrived(self, count: int) -> None:
        if not count:
            raise self._ended(self._frames.buffered)
        self.bytes += count
        self._came = count
        self._frames.received(count)

    def _ended(self, left: int) -> ConnectionLost:
        inside = f" inside a message ({left} bytes of it arrived)" if left else ""
        return ConnectionLost(f"the publisher at {self._peer} closed the connection{inside}", peer=self._peer)
