"""Received messages that are not written yet, limited in bytes so that a slow disk cannot fill the memory.

The drop policy is that of rosbag record: when too many bytes wait, the oldest messages are dropped and
counted.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from rosproto.bag import Connection, RawMessage
from rosproto.codec import AnyMsg
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.node.definitions.type_argument import bundled_text
from rosproto.time import Time

SLICE_BYTES = 8 << 20
OVERHEAD = 200  # bytes that the objects around each message's data take


class Entry(NamedTuple):
    """One received message: topic, the message with its connection, receive time."""

    topic: str
    message: RawMessage
    time: Time


class MessageBuffer:
    """The queue between the threads that receive and the thread that writes.

    The writer is not woken for each message, since that would cost more than writing it. It is woken when
    `wake_bytes` are waiting, and otherwise looks from time to time.

    Args:
        limit: The most bytes that may wait or be in the process of being written.
        wake_bytes: How many waiting bytes wake the writer.

    Attributes:
        received: Messages put in so far.
        dropped: Messages dropped so far.
        bytes: Bytes that wait or are being written.
    """

    def __init__(self, limit: int, wake_bytes: int = 768 * 1024) -> None:
        if limit < 1:
            raise ValueError(f"a buffer of {limit} bytes cannot hold anything; give at least 1")
        self.limit = limit
        self.wake_bytes = min(wake_bytes, limit)
        self.received = 0
        self.dropped = 0
        self.bytes = 0
        self._queue: deque[Entry] = deque()
        self._in_flight = 0
        self._lock = threading.Lock()
        self._wakened = threading.Condition(self._lock)
        self._waiting = False
        self._closed = False

    def put(self, entry: Entry) -> None:
        """Add a message. Any thread may call it, and it never waits for the disk. Ignored after `close`."""
        with self._lock:
            if self._closed:
                return
            self.received += 1
            self._queue.append(entry)
            self.bytes += len(entry[1].data) + OVERHEAD
            while self.bytes > self.limit and self._queue:
                self.bytes -= len(self._queue.popleft().message.data) + OVERHEAD
                self.dropped += 1
            if self._waiting and self.bytes >= self.wake_bytes:
                self._waiting = False
                self._wakened.notify()

    def take(self, timeout: float) -> list[Entry]:
        """Take some of the oldest messages, about `SLICE_BYTES`; those of the previous call now count as
        written.

        Waits for `wake_bytes`, or until the time is over. Only one thread may call it.
        """
        with self._lock:
            self.bytes -= self._in_flight
            self._in_flight = 0
            if self.bytes < self.wake_bytes and not self._closed:
                self._waiting = True
                self._wakened.wait(timeout)
                self._waiting = False
            queue, entries, size = self._queue, [], 0
            while queue and size < SLICE_BYTES:
                entry = queue.popleft()
                entries.append(entry)
                size += len(entry[1].data) + OVERHEAD
            self._in_flight = size
            return entries

    def close(self) -> None:
        """Accept no more messages; waiting ones can still be taken."""
        with self._lock:
            self._closed = True
            self._wakened.notify()

    def __len__(self) -> int:
        return len(self._queue)


# -- what fills it ------------------------------------------------------------------------------------------


_log = get_logger("rosproto.recording")

NS = 1_000_000_000
MAX_CONNECTIONS = 1000  # different publishers' headers on one topic
MAX_CONNECTION_CHARACTERS = 64 << 20  # of these headers, definitions included


class TopicReceiver:
    """Puts the messages of one topic into the buffer, in the thread of the link."""

    def __init__(self, topic: str, node: Node, buffer: MessageBuffer) -> None:
        self._topic = topic
        self._clock = node.clock
        self._put = buffer.put
        self._latest: tuple[dict[str, str], Connection | None] | None = None
        self._warned = False
        self._told_full = False
        self._known: dict[tuple[tuple[str, str], ...], Connection] = {}
        self._known_characters = 0

    def __call__(self, message: AnyMsg) -> None:
        header = message._connection_header or {}
        if header["type"] == "*":
            self._leave_out(header)
            return
        connection = self._connection_for(header)
        if connection is None:
            return
        stamp = Time.from_wire(*divmod(self._clock.now_nsec(), NS))
        raw = RawMessage(connection.type, message._buff, connection.md5sum, (0, 0), connection)
        self._put(Entry(self._topic, raw, stamp))

    def _leave_out(self, header: dict[str, str]) -> None:
        """Warn about a publisher of AnyMsg: without a type its messages could not be read from a bag."""
        if not self._warned:
            self._warned = True
            _log.warning(
                "! %s: %s publishes AnyMsg, which has no type; it is not recorded",
                self._topic,
                header.get("callerid", "")[:200],
            )

    def _connection_for(self, header: dict[str, str]) -> Connection | None:
        """One object for each header of a publisher; two link threads may call this at once.

        A bag lists each of them, and a publisher may send another header on each connection. Beyond a limit,
        messages are assigned to a known connection with the same definition; None if there is none.
        """
        latest = self._latest
        if latest is not None and latest[0] is header:
            return latest[1]
        key = tuple(sorted(header.items()))
        connection = self._known.get(key)
        if connection is None and not self._is_full(key):
            connection = self._known.setdefault(key, _connection(self._topic, header))
            self._known_characters += _characters(key)
        elif connection is None:
            connection = self._alike(header)
        self._latest = header, connection
        return connection

    def _is_full(self, key: tuple[tuple[str, str], ...]) -> bool:
        return (
            len(self._known) >= MAX_CONNECTIONS
            or self._known_characters + _characters(key) > MAX_CONNECTION_CHARACTERS
        )

    def _alike(self, header: dict[str, str]) -> Connection | None:
        wanted = header["type"], header["md5sum"], header.get("latching") == "1"
        for known in list(self._known.values()):
            if (known.type, known.md5sum, known.latching) == wanted:
                return known
        if not self._told_full:
            self._told_full = True
            _log.warning(
                "! %s: publishers have sent %d different headers; messages with others are not recorded",
                self._topic,
                len(self._known),
            )
        return None


def _characters(key: tuple[tuple[str, str], ...]) -> int:
    return sum(len(name) + len(value) for name, value in key)


def _connection(topic: str, header: dict[str, str]) -> Connection:
    kind, md5sum = header["type"], header["md5sum"]
    definition = header.get("message_definition", "") or bundled_text(kind, md5sum)
    return Connection(-1, topic, kind, md5sum, definition, {**header, "message_definition": definition})
