"""Goals that were started through the web. Each has a number and a place in the list, and a thread that waits
for its end. The Chassis's verbs block, so everything here is called from threads.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.text import printable
from woosh_pure.errors import MotionRefused
from woosh_pure.web.problems import Problem, problem_of

if TYPE_CHECKING:
    from woosh_pure.motion.goal import GoalHandle
    from woosh_pure.outcome import Outcome
    from woosh_pure.web.journal import Journal

__all__ = ["Goal", "GoalManager"]

MOST_KEPT, MOST_RUNNING = 200, 8


@dataclass(slots=True)
class Goal:
    """One goal.

    Attributes:
        id: Its number, as text.
        kind: The kind that was requested: "mark", "pose" ...
        who: The name of the client that requested it.
        handle: The library's handle of the goal.
        begun: When it was started, s since 1970.
        entry: The number of its entry in the journal.
        outcome: How it ended; None while it runs.
        error: Why it is not known how it ended; "" otherwise.
    """

    id: str
    kind: str
    who: str
    handle: GoalHandle[Any]
    begun: float
    entry: int
    paused: bool = False
    outcome: Outcome | None = None
    error: str = ""

    @property
    def done(self) -> bool:
        """True once it has ended. Never waits."""
        return self.outcome is not None or bool(self.error)

    def wait(self, timeout: float) -> bool:
        """Block until it has ended, or the time is up."""
        until = time.monotonic() + timeout
        while not self.done and time.monotonic() < until:
            time.sleep(0.01)
        return self.done

    def as_json(self) -> dict[str, Any]:
        """The goal as the API sends it."""
        outcome = self.outcome
        percent = getattr(self.handle.latest_progress, "percent", None)
        return {
            "id": self.id,
            "kind": self.kind,
            "who": self.who,
            "description": printable(self.handle.description),
            "begun": self.begun,
            "state": self._state(),
            "done": self.done,
            "arrived": None if outcome is None else outcome.arrived,
            "progress": printable(self.handle.progress_line()) if outcome is None else "",
            "percent": None if percent is None or not math.isfinite(percent) else round(float(percent), 1),
            "stands_still": None if outcome is None else outcome.stopped,
            "text": self.error if outcome is None else outcome.sentence(),
            "seconds": round(time.time() - self.begun if outcome is None else outcome.seconds, 2),
            "can_pause": not self.done and hasattr(self.handle, "pause"),
        }

    def _state(self) -> str:
        if self.outcome is not None:
            return self.outcome.kind.value
        return "not known" if self.error else "paused" if self.paused else "running"


class GoalManager:
    """The goals of one robot, the last 200. Safe from any thread."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._goals: OrderedDict[str, Goal] = OrderedDict()

    def begin(self, kind: str, who: str, what: str, start: Callable[[], GoalHandle[Any]]) -> Goal:
        """Start a goal; blocks until the robot has accepted or refused it.

        Raises:
            RosError, ValueError: The error of the verb, which is noted in the journal, too.
            Problem: Too many goals run already.
        """
        if len(self.running) >= MOST_RUNNING:
            raise Problem(409, f"{MOST_RUNNING} goals are under way already; cancel one first")
        number = str(next(self._numbers))
        entry = self._journal.begin(who, what, number)
        try:
            handle = start()
        except Exception as error:
            self._journal.end(
                entry, "refused" if isinstance(error, MotionRefused) else "failed", problem_of(error).text
            )
            raise
        goal = Goal(number, kind, who, handle, round(time.time(), 3), entry)
        with self._lock:
            self._goals[number] = goal
            for old in [key for key, one in self._goals.items() if one.done]:
                if len(self._goals) <= MOST_KEPT:
                    break
                del self._goals[old]
        threading.Thread(
            target=self._wait_for_end, args=(goal,), name=f"woosh:web goal {number}", daemon=True
        ).start()
        return goal

    def _wait_for_end(self, goal: Goal) -> None:
        """Wait for the end of the goal, so that its time-out works even if no client waits for it."""
        try:
            outcome = goal.handle.wait(raises=False)
        except RosError as error:
            goal.error = str(error)
            self._journal.end(goal.entry, "not known", str(error))
        else:
            goal.outcome = outcome
            self._journal.end(goal.entry, outcome.kind.value, outcome.sentence())

    def get(self, number: str) -> Goal:
        """The goal with that number.

        Raises:
            Problem: There is no such goal, or it ended too long ago to be kept.
        """
        with self._lock:
            goal = self._goals.get(number)
        if goal is None:
            raise Problem(404, f"there is no goal {number[:20]!r} (any more); the last {MOST_KEPT} are kept")
        return goal

    def all(self) -> list[Goal]:
        """All goals that are kept, the oldest first."""
        with self._lock:
            return list(self._goals.values())

    @property
    def running(self) -> list[Goal]:
        """The goals that have not ended."""
        return [goal for goal in self.all() if not goal.done]
