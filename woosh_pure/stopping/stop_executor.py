"""The threads in which motion is stopped, and the flag that can be set over any frame.

No KeyboardInterrupt reaches those threads, so no second Ctrl-C ends a stop. Python raises it in the main
thread only, at any moment, and as often as somebody presses Ctrl-C or a supervisor sends SIGINT. So the main
thread hands a stop over and waits for it; being interrupted there, it waits on, for as long as the stop
itself may take, and raises the interrupt afterwards.

To hand over is one call of a function written in C (`SimpleQueue.put`), which `except BaseException:` makes
first of all: CPython looks for signals between calls, not before the first one of a handler, so nothing can
come between the interrupt that begins a stop and its beginning.

The threads are started before the first motion: at the end of a program CPython 3.12 starts none any more,
and a program may have come to the limit of its system by the time it stops. They begin a thread for each job
where they can, and do it themselves where they cannot; then there are two of them, so that one job can wait
for another.
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
    """An event that is set once, for good, over any frame. Safe from any thread and any signal handler.

    `threading.Event.set` takes the lock of its condition. A signal handler's stop works in another thread
    while the interrupted frame, perhaps in the middle of `Event.wait`, holds that lock until the handler
    returns. `set` here takes no lock that somebody could hold: a waiter waits in a `SimpleQueue`, whose
    methods are C, and are done or not begun when a handler runs.

    Attributes:
        is_set: Whether it is.
    """

    __slots__ = ("_woken", "is_set")

    def __init__(self) -> None:
        self.is_set = False
        self._woken: queue.SimpleQueue[None] = queue.SimpleQueue()

    def set(self) -> None:
        """Set it, and wake who waits."""
        self.is_set = True
        self._woken.put(None)

    def wait(self, timeout: float) -> bool:
        """Wait until it is set, for so many seconds at most; whether it is."""
        end = time.monotonic() + timeout
        while not self.is_set and (left := end - time.monotonic()) > 0.0:
            try:
                self._woken.get(timeout=min(left, SLICE))
            except queue.Empty:
                continue
            self._woken.put(None)  # the next one's
        return self.is_set


R = TypeVar("R")
_THREADS = 2


class Job(Generic[R]):
    """Something that is done once, however often it is asked for.

    Args:
        work: What to do; it must end by itself.
        seconds: How long it may take at most: nobody waits longer for it.

    Attributes:
        error: What it has raised.
    """

    def __init__(self, work: Callable[[], R], seconds: float) -> None:
        self._work = work
        self._seconds = seconds
        self._end: float | None = None  # of waiting for it, however often somebody does
        self._once = threading.Lock()
        self._over = Flag()
        self._result: list[R] = []
        self.error: BaseException | None = None

    def run(self) -> None:
        """Do it, unless it is done or being done; what it raises is kept for `result`."""
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
        """Whether it is done."""
        return self._over.is_set

    def join(self, seconds: float | None = None) -> BaseException | None:
        """Wait until it is done, or its time is over; the first of the interrupts that came meanwhile.

        Args:
            seconds: Wait no longer than this; None waits as long as it may take.
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
            except BaseException as error:
                interrupt = interrupt or error

    def result(self) -> R:
        """What came of it.

        Raises:
            RosTimeout: It is not done.
            BaseException: What it has raised.
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
    """Does jobs in threads of its own. Safe from any thread.

    Attributes:
        put: Hand a job over, and return at once; `start` has been called.
    """

    def __init__(self) -> None:
        self._jobs: queue.SimpleQueue[Job[Any] | None] = queue.SimpleQueue()
        self.put = self._jobs.put
        self._started_in = 0  # of the process: a forked child has none of these threads

    @property
    def _started(self) -> bool:
        return self._started_in == os.getpid()

    def start(self) -> None:
        """Be ready. To be called before anything is sent that moves the robot.

        Raises:
            RuntimeError: The program ends, and no thread can be started any more.
        """
        if not self._started:
            for _ in range(_THREADS):
                threading.Thread(target=_work, args=(self._jobs,), name="woosh:executor", daemon=True).start()
            self._started_in = os.getpid()

    def end(self) -> None:
        """Nothing moves any more."""
        if self._started:
            self._started_in = 0
            for _ in range(_THREADS):
                self.put(None)

    def do(self, work: Callable[[], R], seconds: float) -> R:
        """Do it now and return its result; a Ctrl-C does not interrupt it, and is raised afterwards.

        Args:
            work: What to do.
            seconds: How long it may take at most.

        Raises:
            BaseException: What `work` has raised; the interrupt that came meanwhile.
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
            begin(job, "woosh:stop")  # one that has begun is not begun again
            interrupt = error
        interrupt = job.join() or interrupt
        if interrupt is not None:
            raise interrupt from job.error
        return job.result()

    def hold(self, job: Job[Any]) -> None:
        """Wait for a job that was handed over, as long as it may take, whatever interrupts come."""
        if self._started:
            job.join()


def begin(job: Job[Any], name: str) -> None:
    """Do a job in a thread of its own, or here when the program ends and no thread can be started."""
    try:
        threading.Thread(target=job.run, name=name, daemon=True).start()
    except RuntimeError:
        job.run()


def _work(jobs: queue.SimpleQueue[Job[Any] | None]) -> None:
    while (job := jobs.get()) is not None:
        begin(job, "woosh:stop")
