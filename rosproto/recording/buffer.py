"""Messages received but not written yet: bounded by bytes, so that a slow disk cannot fill the memory.

The drop policy is rosbag record's: when too many bytes wait, the oldest messages are dropped and counted.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from rosproto.bag import RawMessage
from rosproto.time import Time

__all__ = ["Entry", "MessageBuffer"]

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
            raise ValueError(f"a buffer of {limit} bytes holds nothing; give at least one")
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
            if self.bytes > self.limit:
                self._drop()
            if self._waiting and self.bytes >= self.wake_bytes:
                self._waiting = False
                self._wakened.notify()

    def take(self, timeout: float) -> list[Entry]:
        """Some of the oldest messages, about `SLICE_BYTES`; those of the previous call now count as written.

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
        """Accept no more messages; those that wait can still be taken."""
        with self._lock:
            self._closed = True
            self._wakened.notify()

    def __len__(self) -> int:
        return len(self._queue)

    def _drop(self) -> None:
        assert self._lock.locked()
        while self.bytes > self.limit and self._queue:
            self.bytes -= len(self._queue.popleft()[1].data) + OVERHEAD
            self.dropped += 1
