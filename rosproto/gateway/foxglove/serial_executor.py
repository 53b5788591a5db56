"""Work of one client that may wait for the robot: one after the other, in the threads of the door."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor

from rosproto.logs import get_logger

__all__ = ["Jobs"]

_log = get_logger("rosproto.gateway")


class Jobs:
    """A queue of calls that are done in their order.

    Args:
        pool: Does them.
        most: How many of those that may be dropped wait at most; the oldest goes.
    """

    def __init__(self, pool: Executor, most: int = 100) -> None:
        self._pool = pool
        self._most = most
        self._lock = threading.Lock()
        self._waiting: deque[tuple[Callable[[], object], bool]] = deque()
        self._droppable = 0
        self._running = False
        self._closed = False
        self.dropped = 0

    def add(self, job: Callable[[], object], *, droppable: bool = False) -> None:
        """Have it done; never waits. What it raises is logged."""
        with self._lock:
            if self._closed:
                return
            if droppable:
                self._droppable += 1
                if self._droppable > self._most:
                    self._drop_oldest()
            self._waiting.append((job, droppable))
            if self._running:
                return
            self._running = True
        self._start()

    def _drop_oldest(self) -> None:
        for place, (_, droppable) in enumerate(self._waiting):
            if droppable:
                del self._waiting[place]
                self._droppable -= 1
                self.dropped += 1
                return

    def _start(self) -> None:
        try:
            self._pool.submit(self._run)
        except RuntimeError:  # it is closed: nothing is done any more
            with self._lock:
                self._running = False
                self._waiting.clear()

    def _run(self) -> None:
        for _ in range(100):  # then the others' turn
            with self._lock:
                if not self._waiting:
                    self._running = False
                    return
                job, droppable = self._waiting.popleft()
                self._droppable -= droppable
            try:
                job()
            except Exception:
                _log.exception("! foxglove: something asked by a client failed")
        self._start()

    def close(self) -> None:
        """Do nothing more but what is being done."""
        with self._lock:
            self._closed = True
            self._waiting.clear()
