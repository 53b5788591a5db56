"""The first step of a stop: a thread that never waits writes zeros and cancels on open connections.

`stop`, `close` and the end of a program put a `StopRequest` into a queue (`SimpleQueue.put` is C code and
reentrant). The thread `woosh:immediate-stop`, started before the first motion, marks every motion as asked to
end and writes its zero or cancel on a connection that is open. It takes no lock that another thread of the
program can hold, and creates no thread, socket, file or log line. So it works over any interrupted frame,
and when the system is out of resources. Steps that take time (replies, new connections, checking that the
robot stands) are in `stop`.

Until the end of a motion is seen, its zero or cancel is written again every second while the Chassis is open:
a cancel that was lost with the network arrives when the network is back.

A caller whose stack is used up cannot even put a request into a queue: Python raises RecursionError for the
call, up to 3.11 also for a call of C code. It can set an attribute. `stop`, `cancel`, `close` and the end of
a velocity block do that first of all, and the thread looks for it twenty times a second.
"""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Iterable
from typing import Protocol

from rosproto.transport import next_item
from woosh_pure.stopping.stop_executor import Flag

_LOOK, _IDLE = 0.05, 0.25  # seconds between two looks while a motion is under way, and otherwise
_AGAIN = 1.0  # seconds between two chores


class Stoppable(Protocol):
    """A motion that `ImmediateStop` can end. No method waits, takes a lock, or logs."""

    @property
    def end_due(self) -> bool:
        """Whether its end was asked for and has not been seen."""

    def end_now(self, why: str) -> None:
        """Ask for its end: write the zero or cancel if a connection is open."""

    def end_again(self) -> None:
        """Write the zero or cancel once more."""


class StopRequest:
    """A request to end motions.

    Attributes:
        why: The reason, for outcomes and errors.
        goals: True ends goals and velocity blocks, False velocity blocks only.
        problems: A sentence for each write that failed.
        written: Set when every write was tried.
    """

    def __init__(self, why: str, *, goals: bool = True) -> None:
        self.why = why
        self.goals = goals
        self.problems: list[str] = []
        self.written = Flag()


class ImmediateStop:
    """The thread `woosh:immediate-stop`, which writes zeros and cancels.

    Args:
        under_way: Return the motions under way: with True goals and velocity blocks, with False velocity
            blocks.
        chores: Called every second; must not wait. It returns whether something is left to do.
        look: Called at each look: takes the request of a caller whose stack was used up. Must not wait.
    """

    def __init__(
        self,
        under_way: Callable[[bool], Iterable[Stoppable]],
        chores: Callable[[], object],
        look: Callable[[], object] = lambda: None,
    ) -> None:
        self._under_way = under_way
        self._chores = chores
        self._look = look
        self._asked: queue.SimpleQueue[StopRequest | bool] = queue.SimpleQueue()
        self._started_in = 0  # of the process: a forked child has no such thread
        self._ended = False

    def start(self) -> None:
        """Start the thread if necessary, and none after `end`. Call it before anything is sent that moves the
        robot.

        Raises:
            RuntimeError: No thread can be started.
        """
        if self._ended:
            return
        if not self.started:
            threading.Thread(target=self._work, name="woosh:immediate-stop", daemon=True).start()
            self._started_in = os.getpid()
        self._asked.put(True)

    @property
    def started(self) -> bool:
        """Whether the thread runs in this process."""
        return self._started_in == os.getpid() and not self._ended

    def ask(self, ending: StopRequest) -> StopRequest:
        """Ask the motions under way to end. Returns immediately."""
        if self.started:
            self._asked.put(ending)
        else:
            ending.written.set()  # nothing has ever moved here
        return ending

    def end(self) -> None:
        """End the thread; all motions must have ended."""
        self._ended = True
        self._asked.put(False)

    def _work(self) -> None:
        chores_at, due = 0.0, False
        while True:
            self._look()
            if time.monotonic() >= chores_at:
                due, chores_at = bool(self._chores()), time.monotonic() + _AGAIN
            busy = due or any(True for _ in self._under_way(True))
            try:
                asked = next_item(self._asked, _LOOK if busy else _IDLE)
            except queue.Empty:
                self._again()
                continue
            if asked is False:
                self._asked.put(False)  # two callers may have started two threads
                return
            if isinstance(asked, StopRequest):
                self._first_round(asked)
            chores_at = 0.0

    def _first_round(self, ending: StopRequest) -> None:
        for each in self._under_way(ending.goals):
            try:
                each.end_now(ending.why)
            except Exception as error:  # one failure must not delay the others
                ending.problems.append(f"ending {each} at once ({error})")
        ending.written.set()

    def _again(self) -> None:
        for each in self._under_way(True):
            try:
                if each.end_due:
                    each.end_again()
            except Exception:
                continue
