"""Helper threads that compress and decompress chunks beside the caller.

LZ4 and bz2 release the GIL while they work, so a second thread nearly doubles their speed. Threads start on
demand and end shortly after the last task, so they do not keep a program alive or a file open. A caller that
waits for a result also runs tasks; if no thread can be started (one processor, an interpreter that is
shutting down), the caller runs all of them.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")
LINGER = 0.02  # seconds that a thread waits for more work; cheaper than starting another thread
_WAITING, _RUNNING, _DONE = range(3)


def worker_count() -> int:
    """Number of useful helper threads: this process's processors minus one, at most 3."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on Windows and macOS
    processors = len(affinity(0)) if affinity is not None else os.cpu_count() or 1
    return min(processors - 1, 3)


class Task(Generic[T]):
    """Work that one thread does once.

    Attributes:
        done: True when there is a result or an error.
    """

    __slots__ = ("_problem", "_result", "_state", "_work")

    def __init__(self, work: Callable[[], T]) -> None:
        self._work: Callable[[], T] | None = work
        self._state = _WAITING
        self._result: T | None = None
        self._problem: BaseException | None = None

    @property
    def done(self) -> bool:
        return self._state == _DONE

    def result(self) -> T:
        """Return the result or raise the work's exception; only valid once `done`."""
        assert self._state == _DONE
        if self._problem is not None:
            raise self._problem
        return self._result  # type: ignore[return-value]


class WorkerPool:
    """Runs tasks in the order they were added, several at a time.

    Args:
        name: Of the threads: "rosproto:name".
        most: Maximum number of threads; with 0, the callers of `wait` and `help` do all work.
        daemon: Whether a program may end before the tasks are done.
    """

    def __init__(self, name: str, most: int, *, daemon: bool) -> None:
        self._name = "rosproto:" + name
        self._most = most
        self._daemon = daemon
        self._changed = threading.Condition()
        self._waiting: deque[Task[object]] = deque()
        self._threads = 0
        self._resting = 0

    @property
    def idle(self) -> bool:
        """True when no thread is working."""
        return self._threads == 0

    def add(self, work: Callable[[], T]) -> Task[T]:
        """Queue work, and start a thread unless enough are running."""
        task = Task(work)
        with self._changed:
            self._waiting.append(task)  # type: ignore[arg-type]
            if self._resting >= len(self._waiting):
                self._changed.notify_all()
                return task  # there is an idle thread for each waiting task
            if self._threads >= self._most:
                return task
            self._threads += 1
        try:
            threading.Thread(target=self._run, name=self._name, daemon=self._daemon).start()
        except RuntimeError:  # no thread can be started, now or later: callers do the work themselves
            with self._changed:
                self._threads -= 1
        return task

    def help(self) -> bool:
        """Do the next waiting task in this thread; False when none is waiting."""
        with self._changed:
            if not self._waiting:
                return False
            task = self._waiting.popleft()
            task._state = _RUNNING
        self._do(task)
        return True

    def wait(self, task: Task[T]) -> T:
        """Wait for a task's result; meanwhile this thread runs waiting tasks.

        Raises:
            The exception of the work.
        """
        while not task.done:
            if self.help():
                continue
            with self._changed:
                # Another thread runs the task, which always ends, so this wait ends too.
                self._changed.wait_for(lambda: task.done or bool(self._waiting))
        return task.result()

    def _run(self) -> None:
        """Thread: run tasks until none was waiting for `LINGER` seconds."""
        while True:
            with self._changed:
                if not self._waiting:
                    self._resting += 1
                    self._changed.wait_for(lambda: bool(self._waiting), LINGER)
                    self._resting -= 1
                if not self._waiting:
                    self._threads -= 1
                    return
                task = self._waiting.popleft()
                task._state = _RUNNING
            self._do(task)

    def _do(self, task: Task[T]) -> None:
        assert task._work is not None
        try:
            task._result = task._work()
        except Exception as problem:
            task._problem = problem
        except BaseException:
            # Ctrl-C interrupted the task: queue it again.
            with self._changed:
                task._state = _WAITING
                self._waiting.appendleft(task)  # type: ignore[arg-type]
                self._changed.notify_all()
            raise
        with self._changed:
            task._work = None  # free the referenced objects
            task._state = _DONE
            self._changed.notify_all()
