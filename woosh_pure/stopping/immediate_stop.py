"""The first round of a stop: what can be written at once is written, by a thread that waits for nobody.

`stop`, `close` and the end of a program hand over one item (`SimpleQueue.put`, C, which may interrupt itself)
and the thread `woosh:line`, made before the first motion, marks every motion as asked to end and writes its
zero or its cancel on a connection that stands. Nothing here takes a lock that a program's thread can hold,
and no thread, socket, file or log line is made. So it works over any interrupted frame, and when the system
gives nothing more. What takes time (replies, connections, looking whether the robot stands) comes afterwards,
elsewhere.

What was asked to end and was not seen to end is written again every second, for as long as the Chassis is
open: a cancel that was lost with the network arrives when the network is back.
"""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterable
from typing import Protocol

from woosh_pure.stopping.stop_executor import Flag

_SOON, _SOON_TIMES = 0.05, 5  # seconds; how often after a stop: a velocity may just have been on its way
_AGAIN = 1.0  # seconds


class Stoppable(Protocol):
    """What is under way, as the line sees it. Neither method waits, takes a lock, or logs."""

    @property
    def end_due(self) -> bool:
        """Whether its end was asked for and has not been seen."""

    def end_now(self, why: str) -> None:
        """From now on its end is asked for: write that, if there is a connection."""

    def end_again(self) -> None:
        """Write it once more."""


class StopRequest:
    """One first round.

    Attributes:
        why: In words, for outcomes and errors.
        goals: Whether goals end, too, or velocity blocks only.
        problems: What could not be written, in words.
        written: Set when all of it was tried.
    """

    def __init__(self, why: str, *, goals: bool = True) -> None:
        self.why = why
        self.goals = goals
        self.problems: list[str] = []
        self.written = Flag()


class ImmediateStop:
    """The thread.

    Args:
        under_way: What may have to end; True as argument gives goals, too.
        chores: Called every second while something is under way, or it returned True; must not wait.
    """

    def __init__(
        self, under_way: Callable[[bool], Iterable[Stoppable]], chores: Callable[[], object]
    ) -> None:
        self._under_way = under_way
        self._chores = chores
        self._asked: queue.SimpleQueue[StopRequest | bool] = queue.SimpleQueue()
        self._started_in = 0  # of the process: a forked child has no such thread

    def start(self) -> None:
        """Be ready, before anything is sent that moves the robot.

        Raises:
            RuntimeError: No thread can be started.
        """
        if not self.started:
            threading.Thread(target=self._work, name="woosh:line", daemon=True).start()
            self._started_in = os.getpid()
        self._asked.put(True)

    @property
    def started(self) -> bool:
        """Whether the thread is there."""
        return self._started_in == os.getpid()

    def ask(self, ending: StopRequest) -> StopRequest:
        """Have what is under way end. Returns at once."""
        if self.started:
            self._asked.put(ending)
        else:
            ending.written.set()  # nothing has ever moved here
        return ending

    def end(self) -> None:
        """Nothing moves any more."""
        if self.started:
            self._started_in = 0
            self._asked.put(False)

    def _work(self) -> None:
        soon = 0
        while True:
            due = self._chores()
            busy = due or any(True for _ in self._under_way(True))
            try:
                asked = self._asked.get(timeout=_SOON if soon else _AGAIN if busy else None)
            except queue.Empty:
                soon = max(0, soon - 1)
                self._again()
                continue
            if asked is False:
                return
            if isinstance(asked, StopRequest):
                self._first_round(asked)
                soon = _SOON_TIMES

    def _first_round(self, ending: StopRequest) -> None:
        for each in self._under_way(ending.goals):
            try:
                each.end_now(ending.why)
            except Exception as error:  # one that cannot be written must not hold up the others
                ending.problems.append(f"ending {each} at once ({error})")
        ending.written.set()

    def _again(self) -> None:
        for each in self._under_way(True):
            try:
                if each.end_due:
                    each.end_again()
            except Exception:
                continue
