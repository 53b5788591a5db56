"""What has been received and is not in the file yet: bounded by bytes, so a slow disk cannot fill memory.

Drop policy, as rosbag record has it: when too many bytes wait, the oldest messages are given up and counted.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from rosproto.bag import RawMessage
from rosproto.time import Time

__all__ = ["Entry", "MessageBuffer"]

SLICE_BYTES = 8 << 20
OVERHEAD = 200  # bytes of objects around each message's data


class Entry(NamedTuple):
    """One received message: topic, the message with its connection, receive time."""

    topic: str
    message: RawMessage
    time: Time


class MessageBuffer:
    """Queue between the threads that receive and the one that writes.

    The writer is not woken for each message: that would cost more than writing it. It is woken when
    `wake_bytes` wait, and looks by itself now and then.

    Args:
        limit: Most bytes that wait or are being written.
        wake_bytes: This much is worth waking the writer.

    Attributes:
        received: Messages put in so far.
        dropped: Messages given up so far.
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
        """Add a message; called by any thread, never waits for the disk. Ignored after `close`."""
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
        """Some of the oldest messages, about `SLICE_BYTES`; those of the last call count as written now.

        Waits until it is worth it: `wake_bytes`, or the time is over. Called by one thread.
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
        """Take nothing more; what waits can still be taken."""
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
