"""Threads for work that waits, computes or is due later: asyncio's calls, a bag's chunks, retries of links.

`concurrent.futures` has no daemon threads: a program would wait for a server that has stopped answering.
"""

from __future__ import annotations

import heapq
import itertools
import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from math import inf
from time import monotonic
from typing import Any, TypeVar

T = TypeVar("T")
_Task = tuple[Future[Any], Callable[[], object]]
LINGER = 0.02  # seconds that a thread waits for more work; cheaper than starting another thread
_FIRST_SWEEP = 256  # tasks due later, before the cancelled ones among them are removed


def worker_count() -> int:
    """Number of useful threads for computing: this process's processors, at most 3."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on Windows and macOS
    return min(len(affinity(0)) if affinity is not None else os.cpu_count() or 1, 3)


class WorkerPool:
    """Runs tasks in the order they were added, several at a time, and others when they are due. Threads start
    on demand and end when idle; one stays while a task is due later.

    Args:
        name: Of the threads: "rosproto:..." or "woosh:...".
        max_threads: Maximum number of threads, urgent tasks excepted.
        daemon: Whether a program may end before the tasks are done.
        idle_seconds: A thread without work ends after this. It keeps a program alive unless it is a daemon.
        in_caller: Whether `add` runs the task itself when no thread can be started; otherwise it raises.
        gradual: Start a thread only when the one before has taken its task and another still waits: quick
            tasks that come at once then share a thread, and a slow one delays no other.
    """

    def __init__(
        self,
        name: str,
        max_threads: int,
        *,
        daemon: bool,
        idle_seconds: float = LINGER,
        in_caller: bool = False,
        gradual: bool = False,
    ) -> None:
        self._name = name
        self._max_threads = max_threads
        self._daemon = daemon
        self._idle_seconds = idle_seconds
        self._in_caller = in_caller
        self._gradual = gradual
        # Not SimpleQueue: on a busy machine, its `get` may wait for ever in spite of its timeout.
        self._waiting: deque[_Task] = deque()
        self._later: list[tuple[float, int, _Task]] = []  # heap by due time
        self._watched = inf  # the due time that an idle thread waits for; the others sleep on
        self._numbers = itertools.count()
        self._sweep_at = _FIRST_SWEEP
        self._changed = threading.Condition()  # reentrant: a signal handler may add a task
        self._threads = self._starting = self._idle = 0  # the first includes the second
        self._started: list[threading.Thread] = []
        self._coming = False  # a thread was started or woken, and has not taken a task yet
        self._closed = False

    def add(self, work: Callable[[], T], *, urgent: bool = False) -> Future[T]:
        """Queue work, and start a thread unless enough are idle or running; urgent work never waits for one.

        Raises:
            RuntimeError: No thread can be started, as in an interpreter that is shutting down.
        """
        task: Future[T] = Future()
        item = (task, work)
        with self._changed:
            (self._waiting.appendleft if urgent else self._waiting.append)(item)
            thread = self._thread_wanted(urgent)
        try:
            self._start(thread)
            return task
        except RuntimeError as problem:
            with self._changed:
                if item not in self._waiting or (self._gradual and self._threads):
                    return task  # a thread has taken it, or the next one that is free takes it
                if not self._in_caller:
                    self._waiting.remove(item)
                    self._give_up(problem)
                    raise
                self._threads += 1
        self._run(0.0)
        return task

    def add_later(self, seconds: float, work: Callable[[], T]) -> Future[T]:
        """Queue work that is due in `seconds`; `cancel` of the result drops it.

        Raises:
            RuntimeError: No thread runs, and none can be started.
        """
        task: Future[T] = Future()
        item = (monotonic() + seconds, next(self._numbers), (task, work))
        with self._changed:
            if len(self._later) >= self._sweep_at:
                self._later = [item for item in self._later if not item[2][0].cancelled()]
                heapq.heapify(self._later)
                self._sweep_at = max(_FIRST_SWEEP, 2 * len(self._later))
            heapq.heappush(self._later, item)
            first = self._later[0] is item or self._threads == self._starting
            thread = self._thread_wanted() if first else None
        try:
            self._start(thread)
        except RuntimeError as problem:
            with self._changed:
                if not self._threads and item in self._later:
                    self._later.remove(item)
                    self._give_up(problem)
                    raise
        return task

    def close(self) -> None:
        """End the idle threads now, and each other one when it becomes idle. Does not wait.

        Work that is added later is done, too; work that is due later is dropped.
        """
        with self._changed:
            self._closed = True
            self._later.clear()
            self._changed.notify_all()

    def join(self, timeout: float) -> None:
        """Wait for the end of the threads of a closed pool, except the calling one."""
        end = monotonic() + timeout
        own = threading.current_thread()
        with self._changed:
            self._changed.wait_for(lambda: self._threads <= (own in self._started), timeout)
            started = [thread for thread in self._started if thread is not own and thread.is_alive()]
        for thread in started:
            thread.join(max(0.0, end - monotonic()))

    def _thread_wanted(self, urgent: bool = False) -> threading.Thread | None:
        """Wake an idle thread or return one to `_start`, if there may be one more. The lock is held."""
        gradual = self._gradual and not urgent  # one thread that is coming is not enough for two urgent tasks
        if gradual and self._coming and self._threads > self._starting:
            return None  # a thread runs: the task is not lost if the one that is coming cannot be started
        self._coming = True
        if self._idle >= (1 if gradual else len(self._waiting)):
            self._changed.notify()
        elif self._threads < self._max_threads or urgent:
            self._threads += 1
            self._starting += 1
            run = partial(self._run, self._idle_seconds)
            thread = threading.Thread(target=run, name=self._name, daemon=self._daemon)
            self._started = [each for each in self._started if each.ident is None or each.is_alive()]
            self._started.append(thread)
            return thread
        else:
            self._coming = False
        return None

    def _start(self, thread: threading.Thread | None) -> None:
        """Start a thread without the lock: this lasts until it runs, and others add work meanwhile."""
        if thread is None:
            return
        try:
            thread.start()
        except BaseException:
            with self._changed:
                self._started.remove(thread)
                self._starting -= 1
                self._threads -= 1
                self._coming = False
            raise
        with self._changed:
            self._starting -= 1

    def _give_up(self, problem: RuntimeError) -> None:
        """Fail the work of others that waits for the thread that cannot be started. The lock is held."""
        while not self._threads and self._waiting:
            task, _ = self._waiting.popleft()
            if task.set_running_or_notify_cancel():
                task.set_exception(problem)

    def _run(self, idle_seconds: float) -> None:
        """Run tasks until none was waiting for `idle_seconds`."""
        while (task := self._next(idle_seconds)) is not None:
            if task[0].set_running_or_notify_cancel():
                self._do(*task)
            del task  # free the referenced objects

    def _next(self, idle_seconds: float) -> _Task | None:
        """Wait for a task; None if this thread should end."""
        end = monotonic() + idle_seconds
        with self._changed:
            while True:
                self._coming = False
                now = monotonic()
                while self._later and self._later[0][0] <= now:
                    self._waiting.append(heapq.heappop(self._later)[2])
                if self._waiting:
                    break
                due = self._later[0][0] if self._later else inf
                watches = due < self._watched
                if self._closed or (now >= end and not watches):
                    self._threads -= 1
                    if self._closed:
                        self._changed.notify_all()  # `join`
                    return None
                if watches:
                    self._watched = due
                self._idle += 1
                self._changed.wait((due if watches else end) - now)
                self._idle -= 1
                if watches and self._watched == due:
                    self._watched = inf
            task, thread = self._waiting.popleft(), None
            if self._later or (self._gradual and self._waiting):
                # While this thread is busy, another one takes what still waits or is due later.
                thread = self._thread_wanted()
        with suppress(RuntimeError):  # no more threads: the next one that is free takes it
            self._start(thread)
        return task

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
