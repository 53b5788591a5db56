"""Threads that stop motions without being interrupted by Ctrl-C, and a flag that a signal handler can set.

Python raises KeyboardInterrupt in the main thread only, at any moment, and for every SIGINT. So the main
thread passes a stop to a thread here and waits for it. If it is interrupted while waiting, it continues to
wait, within the time limit of the stop, and raises the interrupt afterwards. A second Ctrl-C cannot end a
stop.

A job is passed by one call of a C function (`SimpleQueue.put`), the first statement after `except
BaseException:`. CPython checks for signals between calls, but not before the first call of a handler, so no
second interrupt can prevent the stop from beginning.

The threads are started before the first motion: CPython 3.12 starts none at the end of a program, and the
system may have no more threads by then. Each starts a new thread for a job if it can, and otherwise runs the
job itself; there are two of them, so that one job can wait for another.
"""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rosproto.errors import RosTimeout
from rosproto.sentence import say

SLICE = 0.1
"""Seconds: on Windows a lock that waits cannot be interrupted, so waits are cut into slices."""


class Flag:
    """An event that is set once and never cleared. Safe from any thread and any signal handler.

    `threading.Event.set` takes a lock. If a signal handler interrupts `Event.wait`, the interrupted frame
    holds that lock until the handler returns, and a stop that runs in another thread could not set the event.
    `set` here waits for nothing: waiters wait at a lock that only it opens.

    Attributes:
        is_set: Whether it is set.
    """

    __slots__ = ("_gate", "is_set")

    def __init__(self) -> None:
        self.is_set = False
        self._gate = threading.Lock()
        self._gate.acquire()

    def set(self) -> None:
        """Set it and wake the waiters."""
        self.is_set = True
        try:
            self._gate.release()
        except RuntimeError:
            pass  # it is open already

    def wait(self, timeout: float) -> bool:
        """Wait until it is set, at most `timeout` seconds; return whether it is."""
        end = time.monotonic() + timeout
        while not self.is_set and (left := end - time.monotonic()) > 0.0:
            if self._gate.acquire(timeout=min(left, SLICE)):
                self.set()  # wakes the next waiter
        return self.is_set


R = TypeVar("R")
_THREADS = 2


class Job(Generic[R]):
    """A function that runs once, however often `run` is called.

    Args:
        work: The function; it must end by itself.
        seconds: Time limit for waiting for it.

    Attributes:
        error: The exception that `work` raised; None if it raised none.
    """

    def __init__(self, work: Callable[[], R], seconds: float) -> None:
        self._work = work
        self._seconds = seconds
        self._end: float | None = None  # deadline of all waits for it
        self._once = threading.Lock()
        self._over = Flag()
        self._result: list[R] = []
        self.error: BaseException | None = None

    def run(self) -> None:
        """Run it unless it has been started; an exception is kept for `result`."""
        if not self._once.acquire(blocking=False):
            return
        try:
            self._result.append(self._work())
        except BaseException as error:
            self.error = error
        finally:
            self._over.set()

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self._over.is_set

    def join(self, seconds: float | None = None) -> BaseException | None:
        """Wait until it has ended or its time limit has passed; return the first interrupt meanwhile.

        Args:
            seconds: A shorter time limit; None uses the job's.
        """
        interrupt: BaseException | None = None
        end = self._end = self._end or time.monotonic() + self._seconds
        if seconds is not None:
            end = min(end, time.monotonic() + seconds)
        while True:
            try:
                while not self._over.is_set and time.monotonic() < end:
                    self._over.wait(SLICE)
                return interrupt
            except RecursionError:
                raise  # at this depth no wait succeeds; the job goes on
            except BaseException as error:
                interrupt = interrupt or error

    def result(self) -> R:
        """Return the result of `work`.

        Raises:
            RosTimeout: It has not ended.
            BaseException: The exception that `work` raised.
        """
        if self.error is not None:
            raise self.error
        if not self._result:
            text = say(
                "not done within {seconds:g} s: it goes on in the background; watch the robot",
                seconds=self._seconds,
            )
            raise RosTimeout(text, what="a stop", seconds=self._seconds)
        return self._result[0]


class StopExecutor:
    """Runs jobs in its threads. Safe from any thread.

    Attributes:
        put: Pass a job and return immediately; call `start` before.
    """

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[Job[Any] | None] = queue.SimpleQueue()
        self.put = self._jobs.put
        self._started_in = 0  # of the process: a forked child has none of these threads
        self._ended = False

    @property
    def _started(self) -> bool:
        return self._started_in == os.getpid() and not self._ended

    def start(self) -> None:
        """Start the threads if necessary, and none after `end`. Call it before anything is sent that moves
        the robot. Two callers at the same time may start more threads than one; all of them end.

        Raises:
            RuntimeError: No thread can be started.
        """
        if not self._started and not self._ended:
            for _ in range(_THREADS):
                threading.Thread(target=_work, args=(self._jobs,), name="woosh:executor", daemon=True).start()
            self._started_in = os.getpid()

    def end(self) -> None:
        """End the threads; all motions must have ended."""
        self._ended = True
        self.put(None)

    def do(self, work: Callable[[], R], seconds: float) -> R:
        """Run `work` and return its result. Ctrl-C does not interrupt it, and is raised afterwards.

        Args:
            work: The function.
            seconds: Time limit.

        Raises:
            BaseException: The exception that `work` raised, or an interrupt that came meanwhile.
        """
        if threading.current_thread() is not threading.main_thread():
            return work()  # no interrupt comes here
        job = Job(work, seconds)
        interrupt = None
        try:
            if self._started:
                self.put(job)
            else:
                begin(job, "woosh:stop")
        except BaseException as error:
            begin(job, "woosh:stop")  # does nothing if it has begun
            interrupt = error
        interrupt = job.join() or interrupt
        if interrupt is not None:
            raise interrupt from job.error
        return job.result()

    def hold(self, job: Job[Any]) -> None:
        """Wait for a job that was passed, within its time limit; interrupts do not end the wait."""
        if self._started:
            job.join()


def begin(job: Job[Any], name: str) -> None:
    """Run a job in a new thread, or in this one if no thread can be started."""
    try:
        threading.Thread(target=job.run, name=name, daemon=True).start()
    except RecursionError:
        raise  # it would fail in this thread, too
    except RuntimeError:
        job.run()


def _work(jobs: queue.SimpleQueue[Job[Any] | None]) -> None:
    while (job := jobs.get()) is not None:
        begin(job, "woosh:stop")
    jobs.put(None)  # for the other threads, also for one that starts only now
