"""The goals that clients of the web server have started, the journal of their commands, and the answers kept
for requests with an `Idempotency-Key`.

A thread waits for the end of each goal. The verbs of the Chassis block, so they are called in threads.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rosproto.errors import RosError
from rosproto.sentence import say, shown
from rosproto.text import short
from woosh_pure.errors import MotionRefused
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.reasons import Readiness
from woosh_pure.web.http_errors import Problem, for_clients, problem_of
from woosh_pure.web.models import Entry
from woosh_pure.web.snapshot import pose_part, reasons_part, said_part

MAX_KEPT_GOALS, MAX_RUNNING_GOALS, MAX_KEYS = 200, 8, 1000
NOT_NOTED = 0
"""The number of no entry in the journal, which ignores its end."""

LENGTH = 200
COMMANDS = {
    "mark": "go to {mark}",
    "park": "park at {mark}",
    "charge": "charge at {mark}",
    "load": "load at {mark}",
    "unload": "unload at {mark}",
    "pose": "go to {x:.2f} {y:.2f} m, {yaw:.2f} rad",
    "move": "move {distance:.2f} m",
    "rotate": "rotate {angle:.2f} rad",
    "cancel": "cancel goal {goal}",
    "pause": "pause goal {goal}",
    "resume": "resume goal {goal}",
    "record": "record bag {recording}",
    "end_record": "end bag {recording}",
    "delete_record": "delete bag {recording}",
    "set_pose": "set the pose to {x:.2f} {y:.2f} m, {yaw:.2f} rad",
    "stop": "stop",
    "stop_ours": "stop what is ours",
    "drive": "drive by hand",
    "save_mark": "save mark {mark}",
    "change_mark": "change mark {mark}",
    "delete_mark": "delete mark {mark}",
    "take_over": "take over from {holder}",
    "simulate": "change the simulation: {changes}",
    "switch_map": "switch to the map {map} of {scene}",
    "mission": "mission {mission}",
    "save_mission": "save mission {mission}",
    "delete_mission": "delete mission {mission}",
    "pause_missions": "pause the missions",
    "resume_missions": "resume the missions",
    "stop_missions": "stop the mission",
    "clear_missions": "empty the queue",
    "answer_mission": "answer {answer}",
}


class Command(NamedTuple):
    """A command of a client.

    Attributes:
        text: The command as a sentence.
        key: Its kind, for programs that have their own words: "mark", "rotate", "stop" ...
        values: Its values, in m and rad.
    """

    text: str
    key: str = ""
    values: Mapping[str, object] = {}


def command(key: str, **values: object) -> Command:
    """Make a command from its key and values."""
    return Command(say(COMMANDS[key], **values), key, values)


class Journal:
    """The last entries; older ones are dropped. Safe from any thread.

    Attributes:
        version: Grows with each change.
    """

    def __init__(self, length: int = LENGTH) -> None:
        self._length = length
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._entries: dict[int, tuple[int, Entry]] = {}  # with the version of its last change
        self.version = 0

    def begin(self, who: str, what: Command | str, goal: str = "", *, at: float | None = None) -> int:
        """Add an entry for a command that begins, now or at a time. Return its number, for `end`."""
        text, key, values = what if isinstance(what, Command) else Command(what)
        with self._lock:
            number = next(self._numbers)
            began, who, text = round(at or time.time(), 3), short(shown(who), 200), short(shown(text), 200)
            entry = Entry(
                id=number,
                at=began,
                who=who,
                what=text,
                state="under way",
                text="",
                ended=None,
                goal=goal,
                key=key,
                values=dict(values),
                reasons=[],
                said=None,
            )
            self._put(entry)
            while len(self._entries) > self._length:
                del self._entries[next(iter(self._entries))]
            return number

    def end(
        self,
        number: int,
        state: str,
        text: str = "",
        *,
        reasons: tuple[dict[str, object], ...] = (),
        said: dict[str, str] | None = None,
        at: float | None = None,
    ) -> None:
        """Note the end of an entry, with `reasons` and `said`. A dropped entry is ignored."""
        ended, text = round(at or time.time(), 3), short(shown(text), 1000)
        changes = {"state": state, "text": text, "ended": ended, "reasons": reasons, "said": said}
        with self._lock:
            if number in self._entries:
                _, entry = self._entries[number]
                self._put(Entry.model_validate({**entry.model_dump(), **changes}))  # a copy: others hold it

    def note(
        self, who: str, what: Command | str, state: str = "done", text: str = "", at: float | None = None
    ) -> None:
        """Add an entry for a finished command."""
        self.end(self.begin(who, what, at=at), state, text, at=at)

    def entries(self) -> list[Entry]:
        """Return all entries, the oldest first."""
        with self._lock:
            return [entry for _, entry in self._entries.values()]

    def since(self, version: int) -> list[Entry]:
        """Return the entries added or changed after that version."""
        with self._lock:
            return [entry for changed, entry in self._entries.values() if changed > version]

    def _put(self, entry: Entry) -> None:
        self.version += 1
        self._entries[entry.id] = self.version, entry


@dataclass(slots=True)
class Goal:
    """One goal.

    Attributes:
        id: Its number, as text.
        kind: The kind that was requested: "mark", "pose" ...
        what: What was requested.
        who: The name of the client that requested it.
        handle: The library's handle of the goal.
        begun: When it was started, s since 1970, for people.
        entry: The number of its entry in the journal; `NOT_NOTED` without one.
        outcome: How it ended; None while it runs.
        error: Why the outcome is unknown; "" otherwise.
        start, target: Places in the map, {x, y} in m; None if not known.
        reasons: The reasons not to move when it failed; the cause first.
        said: The robot's message about its end, {text, text_zh}; None without one.
        ended: Set once it has ended.
    """

    id: str
    kind: str
    what: Command
    who: str
    handle: GoalHandle[Any]
    begun: float
    entry: int
    paused: bool = False
    outcome: Outcome | None = None
    error: str = ""
    start: Mapping[str, float] | None = None
    target: Mapping[str, float] | None = None
    reasons: tuple[dict[str, object], ...] = ()
    said: dict[str, str] | None = None
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def done(self) -> bool:
        """True once it has ended. Never waits."""
        return self.ended.is_set()

    def as_json(self) -> dict[str, object]:
        """The goal as the API sends it."""
        outcome = self.outcome
        progress = self.handle.progress
        return {
            "id": self.id,
            "kind": self.kind,
            "key": self.what.key,
            "values": dict(self.what.values),
            "who": self.who,
            "description": shown(self.handle.description),
            "begun": self.begun,
            "state": self._state(),
            "done": self.done,
            "arrived": None if outcome is None else outcome.arrived,
            "progress": shown(str(progress)) if outcome is None else "",
            "percent": _rounded(progress.percent),
            "metres_left": _rounded(progress.metres_left),
            "pose": None if progress.pose is None else pose_part(progress.pose),
            "stands_still": None if outcome is None else outcome.stopped,
            "text": self.error if outcome is None else for_clients(str(outcome)),
            "seconds": round(progress.seconds, 2),
            "can_pause": not self.done and hasattr(self.handle, "pause"),
            "start": self.start,
            "target": self.target,
            "reasons": list(self.reasons),
            "said": self.said,
        }

    def _state(self) -> str:
        if self.outcome is not None:
            return self.outcome.kind.value
        return "not known" if self.error else "paused" if self.paused else "running"


def _rounded(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else round(float(number), 1)


class GoalManager:
    """The goals of one robot, the last 200. Safe from any thread.

    Args:
        journal: Gets an entry for each goal.
        readiness: Asked for the reasons when a goal has failed.
    """

    def __init__(self, journal: Journal, readiness: Callable[[], Readiness]) -> None:
        self._journal, self._readiness = journal, readiness
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._goals: OrderedDict[str, Goal] = OrderedDict()

    def begin(
        self,
        kind: str,
        who: str,
        what: Command,
        begin: Callable[[], GoalHandle[Any]],
        *,
        start: Mapping[str, float] | None = None,
        target: Mapping[str, float] | None = None,
        noted: bool = True,
    ) -> Goal:
        """Start a goal; blocks until the robot has accepted or refused it.

        Args:
            kind, who, what, start, target: See `Goal`.
            begin: The verb of the chassis.
            noted: Whether the journal gets an entry for it; False for a caller that makes one itself.

        Raises:
            RosError, ValueError: The error of the verb. The journal notes it, too.
            Problem: Too many goals run already.
        """
        if len(self.running) >= MAX_RUNNING_GOALS:
            text = "{max_running} goals are under way already; cancel one first"
            raise Problem(409, text, "too-many-goals", max_running=MAX_RUNNING_GOALS)
        number = str(next(self._numbers))
        entry = self._journal.begin(who, what, number) if noted else NOT_NOTED
        try:
            handle = begin()
        except Exception as error:
            text = problem_of(error).text
            if isinstance(error, MotionRefused):
                reasons, said = tuple(reasons_part(error.reasons)), said_part(error.robot_text)
                self._journal.end(entry, "refused", text, reasons=reasons, said=said)
            else:
                self._journal.end(entry, "failed", text)
            raise
        begun = round(time.time(), 3)
        goal = Goal(number, kind, what, who, handle, begun, entry, start=start, target=target)
        with self._lock:
            self._goals[number] = goal
            for old in [key for key, one in self._goals.items() if one.done]:
                if len(self._goals) <= MAX_KEPT_GOALS:
                    break
                del self._goals[old]
        threading.Thread(
            target=self._wait_for_end, args=(goal,), name=f"woosh:web goal {number}", daemon=True
        ).start()
        return goal

    def _wait_for_end(self, goal: Goal) -> None:
        """Wait for the end of the goal, so that its time-out works even if no client waits."""
        try:
            outcome = goal.handle.wait(raises=False)
        except RosError as error:
            goal.error = str(error)
            goal.ended.set()
            self._journal.end(goal.entry, "not known", str(error))
        else:
            goal.outcome = outcome
            goal.said = None if outcome.arrived else said_part(outcome.text)
            goal.ended.set()  # first, because the following calls may block
            goal.reasons = self._reasons(outcome)
            text = for_clients(str(outcome))
            self._journal.end(goal.entry, outcome.kind.value, text, reasons=goal.reasons, said=goal.said)

    def _reasons(self, outcome: Outcome) -> tuple[dict[str, object], ...]:
        """Return the reasons in the robot's state for the failure of a goal."""
        if outcome.kind not in (OutcomeKind.FAILED, OutcomeKind.REJECTED):
            return ()
        try:
            return tuple(reasons_part(r for r in self._readiness().reasons if r.blocking))
        except RosError:
            return ()  # the robot is unreachable: only the outcome is known

    def get(self, number: str) -> Goal:
        """Return the goal with that number.

        Raises:
            Problem: There is no such goal, or it ended too long ago to be kept.
        """
        with self._lock:
            goal = self._goals.get(number)
        if goal is None:
            text = "goal {number!r} was not found; the last {max_kept} goals are kept"
            raise Problem(404, text, number=number[:20], max_kept=MAX_KEPT_GOALS)
        return goal

    def remove(self, number: str) -> None:
        """Delete a goal that has ended. Its entry in the journal stays."""
        with self._lock:
            self._goals.pop(number, None)

    def all(self) -> list[Goal]:
        """Return all kept goals, the oldest first."""
        with self._lock:
            return list(self._goals.values())

    @property
    def running(self) -> list[Goal]:
        """Return the goals that have not ended."""
        return [goal for goal in self.all() if not goal.done]


@dataclass(slots=True)
class _KeyedRequest:
    """A request with a key, and its answer; None until there is one."""

    request: str
    answer: dict[str, object] | Problem | None = None


class IdempotentAnswers:
    """The last 1000 answers to requests with a key (IETF draft `Idempotency-Key`). A repeated request is not
    carried out again and gets the first answer, also if that is a refusal. Safe from any thread.
    """

    def __init__(self, max_answers: int = MAX_KEYS) -> None:
        self._max_answers = max_answers
        self._lock = threading.Lock()
        self._known: OrderedDict[tuple[str, str], _KeyedRequest] = OrderedDict()

    def give(
        self, who: str, key: str, request: str, act: Callable[[], dict[str, object]]
    ) -> dict[str, object]:
        """Return the answer to the first request with this key, or else the result of `act`.

        Args:
            who: The client; each has separate keys.
            request: The content of the request, as text.

        Raises:
            Problem: The answer is a refusal, or another request has this key, or it is still in progress.
        """
        with self._lock:
            first = self._known.get((who, key))
            if first is None:
                mine = self._known[who, key] = _KeyedRequest(request)
                while len(self._known) > self._max_answers:
                    self._known.popitem(last=False)
        if first is None:
            try:
                mine.answer = act()
            except Exception as error:
                mine.answer = problem_of(error).again()
            first = mine
        if first.request != request:
            text = "Idempotency-Key {key!r} was sent before, with another body; take a new key"
            raise Problem(422, text, "key-used", key=key)
        answer = first.answer
        if answer is None:
            text = "the first request with Idempotency-Key {key!r} is still being processed"
            raise Problem(409, text, "key-in-use", key=key)
        if isinstance(answer, Problem):
            raise answer.again()
        return answer
