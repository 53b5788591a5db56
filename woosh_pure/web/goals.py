"""The goals that were started through the web, and the journal: what was asked for, by whom, how it ended.

Each goal has a number and a place in the list, and a thread that waits for its end. The Chassis's verbs
block, so the goals are called from threads.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.text import printable
from woosh_pure.errors import MotionRefused
from woosh_pure.motion.goal import GoalHandle
from woosh_pure.outcome import Outcome
from woosh_pure.web.problems import Problem, problem_of

MOST_KEPT, MOST_RUNNING = 200, 8


LENGTH = 200


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of the journal.

    Attributes:
        id: Grows by one with each entry.
        at: When it began, s since 1970.
        who: The name of the client that asked for it.
        what: What was asked for, in words.
        state: "under way", or how it ended: "arrived", "failed", "cancelled", "done", "refused" ...
        text: The library's sentence about how it ended; "" before that.
        ended: When it ended, s since 1970; None before that.
        goal: Id of the goal that the entry is about; "" if it is not about a goal.
    """

    id: int
    at: float
    who: str
    what: str
    state: str = "under way"
    text: str = ""
    ended: float | None = None
    goal: str = ""

    def as_json(self) -> dict[str, Any]:
        """The entry as the API sends it."""
        return asdict(self)


class Journal:
    """The last entries; older ones are dropped. Safe from any thread.

    Attributes:
        version: Grows with each change.
    """

    def __init__(self, length: int = LENGTH) -> None:
        self._length = length
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._entries: OrderedDict[int, Entry] = OrderedDict()
        self._changed: OrderedDict[int, int] = OrderedDict()
        self.version = 0

    def begin(self, who: str, what: str, goal: str = "") -> int:
        """Add an entry for something that was asked for; returns its number, to be given to `end`."""
        with self._lock:
            number = next(self._numbers)
            self._put(Entry(number, round(time.time(), 3), _short(who), _short(what), goal=goal))
            while len(self._entries) > self._length:
                oldest, _ = self._entries.popitem(last=False)
                self._changed.pop(oldest, None)
            return number

    def end(self, number: int, state: str, text: str = "") -> None:
        """Note how it ended. Does nothing if the entry has been dropped meanwhile."""
        with self._lock:
            entry = self._entries.get(number)
            if entry is not None:
                self._put(replace(entry, state=state, text=_short(text, 1000), ended=round(time.time(), 3)))

    def note(self, who: str, what: str, state: str = "done", text: str = "") -> None:
        """Add an entry for something that is done already."""
        self.end(self.begin(who, what), state, text)

    def entries(self) -> list[Entry]:
        """All entries, the oldest first."""
        with self._lock:
            return list(self._entries.values())

    def since(self, version: int) -> list[Entry]:
        """The entries that were added or changed after that version."""
        with self._lock:
            return [self._entries[number] for number, when in self._changed.items() if when > version]

    def _put(self, entry: Entry) -> None:
        self.version += 1
        self._entries[entry.id] = entry
        self._changed[entry.id] = self.version


def _short(text: str, most: int = 200) -> str:
    """One printable line of limited length, whatever a client has sent."""
    text = printable(text)
    return text if len(text) <= most else text[: most - 1] + "…"


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
            raise Problem(
                409,
                say(
                    "{most_running} goals are under way already; cancel one first", most_running=MOST_RUNNING
                ),
            )
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
            raise Problem(
                404,
                say(
                    "there is no goal {number!r} (any more); the last {most_kept} are kept",
                    number=number[:20],
                    most_kept=MOST_KEPT,
                ),
            )
        return goal

    def all(self) -> list[Goal]:
        """All goals that are kept, the oldest first."""
        with self._lock:
            return list(self._goals.values())

    @property
    def running(self) -> list[Goal]:
        """The goals that have not ended."""
        return [goal for goal in self.all() if not goal.done]
