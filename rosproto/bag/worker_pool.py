"""Helper threads that compress and decompress chunks beside the caller.

LZ4 and bz2 release the GIL while they work, so several threads multiply their speed. Threads start on demand
and end shortly after the last task, so they do not keep a program alive or a file open. If no thread can be
started (an interpreter that is shutting down), the caller does the work.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

T = TypeVar("T")
LINGER = 0.02  # seconds that a thread waits for more work; cheaper than starting another thread


def worker_count() -> int:
    """Number of useful helper threads: this process's processors, at most 3."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on Windows and macOS
    return min(len(affinity(0)) if affinity is not None else os.cpu_count() or 1, 3)


class WorkerPool:
    """Runs tasks in the order they were added, several at a time.

    `concurrent.futures` has no daemon threads: a program would wait for a server that has stopped answering.

    Args:
        name: Of the threads: "rosproto:name".
        most: Maximum number of threads.
        daemon: Whether a program may end before the tasks are done.
    """

    def __init__(self, name: str, most: int, *, daemon: bool) -> None:
        self._name = "rosproto:" + name
        self._most = most
        self._daemon = daemon
        # Not SimpleQueue: on a busy machine, its `get` may wait for ever in spite of its timeout.
        self._waiting: deque[tuple[Future[Any], Callable[[], Any]]] = deque()
        self._changed = threading.Condition()  # reentrant: a signal handler may add a task
        self._threads = 0

    def add(self, work: Callable[[], T]) -> Future[T]:
        """Queue work, and start a thread unless enough are running."""
        task: Future[T] = Future()
        with self._changed:
            self._waiting.append((task, work))
            if self._threads >= self._most:
                self._changed.notify()
                return task
            self._threads += 1
        try:
            threading.Thread(target=self._run, args=(LINGER,), name=self._name, daemon=self._daemon).start()
        except RuntimeError:
            self._run(0.0)
        return task

    def _run(self, linger: float) -> None:
        """Run tasks until none was waiting for `linger` seconds."""
        while True:
            with self._changed:
                if not self._changed.wait_for(lambda: bool(self._waiting), linger):
                    self._threads -= 1
                    return
                task, work = self._waiting.popleft()
            try:
                result = work()
            except BaseException as problem:
                task.set_exception(problem)
            else:
                task.set_result(result)
                del result
            del task, work  # free the referenced objects
