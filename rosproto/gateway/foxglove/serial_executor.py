"""Runs the work of one client, which may wait for the robot, one call after another on a shared pool."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor

from rosproto.logs import get_logger

__all__ = ["SerialExecutor"]

_log = get_logger("rosproto.gateway")

CALLS_PER_TURN = 100  # before other executors of the pool have their turn


class SerialExecutor:
    """An executor whose calls run in order, never two at a time.

    Args:
        pool: Runs them.
        max_droppable: How many droppable calls may wait; the oldest is dropped first.

    Attributes:
        dropped: Calls dropped so far.
    """

    def __init__(self, pool: Executor, max_droppable: int = 100) -> None:
        self._pool = pool
        self._max_droppable = max_droppable
        self._lock = threading.Lock()
        self._waiting: deque[tuple[Callable[[], object], bool]] = deque()
        self._droppable = 0
        self._running = False
        self._closed = False
        self.dropped = 0

    def submit(self, call: Callable[[], object], *, droppable: bool = False) -> None:
        """Queue a call; never waits. Its exceptions are logged."""
        with self._lock:
            if self._closed:
                return
            if droppable:
                self._droppable += 1
                if self._droppable > self._max_droppable:
                    self._drop_oldest()
            self._waiting.append((call, droppable))
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
        except RuntimeError:  # the pool is closed
            with self._lock:
                self._running = False
                self._waiting.clear()

    def _run(self) -> None:
        for _ in range(CALLS_PER_TURN):
            with self._lock:
                if not self._waiting:
                    self._running = False
                    return
                call, droppable = self._waiting.popleft()
                self._droppable -= droppable
            try:
                call()
            except Exception:
                _log.exception("! foxglove: a request of a client failed")
        self._start()

    def close(self) -> None:
        """Drop what is waiting; the call under way goes on."""
        with self._lock:
            self._closed = True
            self._waiting.clear()
