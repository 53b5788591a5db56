"""A bounded queue from threads to awaiting tasks.

One wake-up of the loop takes everything that has arrived: a call_soon_threadsafe per message (a system call
and a pass of the loop each) would limit a fast topic.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from typing import Generic, TypeVar

from rosproto.aio.pool import notify
from rosproto.coercion import as_float

T = TypeVar("T")


class Closed(Exception):
    """No more items will come; ends an `async for`."""


class Mailbox(Generic[T]):
    """A queue filled from any thread and emptied in the loop that it was created in.

    Attributes:
        size: Most items; beyond it the oldest is dropped. 0 means no limit.
        dropped: Number of dropped items.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.dropped = 0
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._items: deque[T] = deque()
        self._waiters: deque[asyncio.Future[None]] = deque()
        self._notified = False
        self._closed = False

    def __len__(self) -> int:
        return len(self._items)

    def put(self, item: T) -> None:
        """Add an item, from any thread; never blocks."""
        with self._lock:
            if self._closed:
                return
            if self.size and len(self._items) >= self.size:
                self._items.popleft()
                self.dropped += 1
            self._items.append(item)
            notified, self._notified = self._notified, True
        if not notified:
            notify(self._loop, self._wake)

    def close(self) -> None:
        """Accept no more items, from any thread; those in the queue can still be taken."""
        with self._lock:
            self._closed = True
        notify(self._loop, self._wake)

    def _wake(self) -> None:
        with self._lock:
            self._notified = False
            count = len(self._waiters) if self._closed else len(self._items)
        for waiter in self._waiters:
            if count <= 0:
                break
            if not waiter.done():
                waiter.set_result(None)
                count -= 1

    async def get(self, timeout: float | None = None) -> T:
        """Take the next item.

        Raises:
            Closed: There is none, and none will come.
            TimeoutError: None came within `timeout` seconds.
        """
        if timeout is None:
            return await self._next()
        return await asyncio.wait_for(self._next(), as_float(timeout))

    async def _next(self) -> T:
        while True:
            with self._lock:
                if self._items:
                    return self._items.popleft()
                if self._closed:
                    raise Closed
            waiter: asyncio.Future[None] = self._loop.create_future()
            self._waiters.append(waiter)
            try:
                await waiter
            finally:
                self._waiters.remove(waiter)
                if waiter.done() and not waiter.cancelled() and self._items:
                    self._wake()  # cancelled after being woken, or more items: wake the next task
