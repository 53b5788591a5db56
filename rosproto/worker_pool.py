"""Threads for work that waits or computes beside the caller: those of asyncio's calls, and of a bag's chunks.

`concurrent.futures` has no daemon threads: a program would wait for a server that has stopped answering.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

T = TypeVar("T")
LINGER = 0.02  # seconds that a thread waits for more work; cheaper than starting another thread


def worker_count() -> int:
    """Number of useful threads for computing: this process's processors, at most 3."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on Windows and macOS
    return min(len(affinity(0)) if affinity is not None else os.cpu_count() or 1, 3)


class WorkerPool:
    """Runs tasks in the order they were added, several at a time. Threads start on demand and end when idle.

    Args:
        name: Of the threads: "rosproto:..." or "woosh:...".
        max_threads: Maximum number of threads, urgent tasks excepted.
        daemon: Whether a program may end before the tasks are done.
        idle_seconds: A thread without work ends after this. It keeps a program alive unless it is a daemon.
        in_caller: Whether `add` runs the task itself when no thread can be started; otherwise it raises.
    """

    def __init__(
        self,
        name: str,
        max_threads: int,
        *,
        daemon: bool,
        idle_seconds: float = LINGER,
        in_caller: bool = False,
    ) -> None:
        self._name = name
        self._max_threads = max_threads
        self._daemon = daemon
        self._idle_seconds = idle_seconds
        self._in_caller = in_caller
        # Not SimpleQueue: on a busy machine, its `get` may wait for ever in spite of its timeout.
        self._waiting: deque[tuple[Future[Any], Callable[[], object]]] = deque()
        self._changed = threading.Condition()  # reentrant: a signal handler may add a task
        self._threads = self._idle = 0
        self._closed = False

    def add(self, work: Callable[[], T], *, urgent: bool = False) -> Future[T]:
        """Queue work, and start a thread unless enough are idle or running; urgent work never waits for one.

        Raises:
            RuntimeError: No thread can be started, as in an interpreter that is shutting down.
        """
        task: Future[T] = Future()
        with self._changed:
            (self._waiting.appendleft if urgent else self._waiting.append)((task, work))
            if self._idle >= len(self._waiting):
                self._changed.notify()
                return task
            if self._threads >= self._max_threads and not urgent:
                return task
            self._threads += 1
        run = partial(self._run, self._idle_seconds)
        try:
            threading.Thread(target=run, name=self._name, daemon=self._daemon).start()
        except RuntimeError:
            if not self._in_caller:
                with self._changed:
                    self._threads -= 1
                    self._waiting.remove((task, work))
                raise
            self._run(0.0)
        return task

    def close(self) -> None:
        """End the idle threads now, and each other one when it becomes idle. Does not wait.

        Work that is added later is done, too.
        """
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _run(self, idle_seconds: float) -> None:
        """Run tasks until none was waiting for `idle_seconds`."""
        while True:
            with self._changed:
                if not self._waiting:
                    self._idle += 1
                    self._changed.wait_for(lambda: self._waiting or self._closed, idle_seconds)
                    self._idle -= 1
                if not self._waiting:
                    self._threads -= 1
                    return
                task, work = self._waiting.popleft()
            if task.set_running_or_notify_cancel():
                self._do(task, work)
            del task, work  # free the referenced objects

    def _do(self, task: Future[T], work: Callable[[], T]) -> None:
        try:
            deliver = partial(task.set_result, work())
        except BaseException as problem:
            deliver = partial(task.set_exception, problem)
        # Idle before the result is delivered: the work that follows it then finds this thread.
        with self._changed:
            self._idle += 1
        deliver()
        with self._changed:
            self._idle -= 1
