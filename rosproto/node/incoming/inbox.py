"""What a subscriber has received and its program has not taken yet.

Drop policy: at most `size` messages wait, the oldest is dropped and counted. So `size=1` holds the newest
message, however slow the program is, and memory is bounded however fast the publisher is.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from typing import Any

from rosproto.transport.waiting import wait_for


class Inbox:
    """Bounded queue of (message, receive time), oldest dropped; filled by link threads.

    Attributes:
        lock, condition: Guard everything; two faces of one lock (the bare one is entered twice as fast).
        size: Most messages that wait.
        received: Messages put in so far.
        dropped: Messages given up so far.
        latest: The newest message, taken or not; None before the first.
        closed: Nothing more comes.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.received = 0
        self.dropped = 0
        self.latest: Any = None
        self.lock = threading.Lock()
        self.condition = threading.Condition(self.lock)
        self._queue: deque[tuple[Any, float]] = deque()
        self._waiters = 0
        self.closed = False

    def abandon(self) -> None:
        """In a fork of this process: closed, whoever held the lock in the parent."""
        self.lock = threading.Lock()
        self.condition = threading.Condition(self.lock)
        self.close()

    def put(self, batch: Sequence[Any], stamp: float) -> None:
        """Add messages, the newest last."""
        with self.lock:
            self.put_locked(batch, stamp)

    def put_locked(self, batch: Sequence[Any], stamp: float, *, older: bool = False) -> None:
        """As `put`, for a caller that holds `lock`; with `older` they go before what waits already."""
        if self.closed:
            return
        queue = self._queue
        if older:
            queue.extendleft((message, stamp) for message in reversed(batch))
        else:
            self.received += len(batch)
            self.latest = batch[-1]
            if len(batch) > self.size:
                self.dropped += len(batch) - self.size
                batch = batch[-self.size :]
            queue.extend([(message, stamp) for message in batch])
        while len(queue) > self.size:
            queue.popleft()
            self.dropped += 1
        if self._waiters:
            self.condition.notify_all()

    def count(self, batch: Sequence[Any]) -> None:
        """Note messages that go to a callback directly; for a caller that holds `lock`."""
        self.received += len(batch)
        self.latest = batch[-1]

    def get(self, timeout: float | None) -> tuple[Any, float] | None:
        """Take the oldest message; None when there was none in time, or the inbox is closed and empty."""
        with self.condition:
            if not self._queue and not self.closed:
                self._waiters += 1
                try:
                    wait_for(self.condition, lambda: self._queue or self.closed, timeout)
                finally:
                    self._waiters -= 1
            return self._queue.popleft() if self._queue else None

    def get_some(self, timeout: float | None, most: int) -> list[Any]:
        """As `get`, but the messages alone, and up to `most` of them when more wait."""
        first = self.get(timeout)
        if first is None or most == 1:
            return [] if first is None else [first[0]]
        with self.lock:
            queue = self._queue
            return [first[0], *(queue.popleft()[0] for _ in range(min(most - 1, len(queue))))]

    def close(self) -> None:
        """Nothing more comes; whoever waits is woken. What waits is dropped."""
        with self.condition:
            self.closed = True
            self.dropped += len(self._queue)
            self._queue.clear()
            self.condition.notify_all()

    def __len__(self) -> int:
        return len(self._queue)
