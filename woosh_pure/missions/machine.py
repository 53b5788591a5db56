"""The machine of missions: `step` takes a state and an event, and returns the next state and the effects. Pure:
no clock, threads or network.

A run goes through these phases:

    waiting      between two steps, or until the robot is ready: `reason` says for what
    running      a step is under way; `token` names it
    retrying     a step has failed, and is tried again at `deadline`
    asking       a question waits for an answer
    interrupted  the program was killed; a person or program resumes it
    done, failed, stopped

`paused` is beside them: nothing begins while it is set. The start of a program moves nothing: what was running is
interrupted, and a step that may have begun is "not known", so a question with `UNKNOWN_ANSWERS` follows `Resume`.
A stop by anybody ends the run and pauses the queue.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

from woosh_pure.missions.mission import Mission, MissionError, Step, Value


class Phase(str, Enum):
    """What a run is doing."""

    WAITING = "waiting"
    RUNNING = "running"
    RETRYING = "retrying"
    ASKING = "asking"
    INTERRUPTED = "interrupted"
    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"

    @property
    def over(self) -> bool:
        """Whether the run has ended."""
        return self in (Phase.DONE, Phase.FAILED, Phase.STOPPED)


UNKNOWN_ANSWERS = ("done", "again", "stop")
"""To the question what became of a step that was running when the program ended."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A mission in the queue, with a copy of its steps: a file that changes later does not matter.

    Attributes:
        id: Its number, as text; the run has the same.
        mission: The steps.
        parameters: All of them.
        by: Who appended it.
        file: Where it came from; "" if from no file.
    """

    id: str
    mission: Mission
    parameters: Mapping[str, Value] = field(default_factory=dict)
    by: str = ""
    file: str = ""


@dataclass(frozen=True, slots=True)
class Question:
    """A question to a person.

    Attributes:
        text: The question.
        answers: Two to five.
        default: The answer at the timeout; "" without one.
        unknown: Whether it asks what became of a step that was interrupted.
    """

    text: str
    answers: tuple[str, ...]
    default: str = ""
    unknown: bool = False


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a mission.

    Attributes:
        entry: The mission, its parameters, who started it; `entry.id` is the id of the run.
        phase: See the module.
        at: The place of the current step, from 0, in `mission.steps`, or in `on_abort` while `aborting`.
        aborting: The mission has failed, and its `on_abort` steps are carried out.
        charging: A guard has inserted charging before the current step.
        paused: Nothing begins until it is resumed.
        reason: Why it waits, failed or was stopped, in words; "" without one.
        question: While asking.
        attempt: Failures of the current step so far.
        token: Of the effect that was begun last; it grows.
        begun: Whether that may be under way, also of an interrupted run.
        deadline: In the machine's time, of a question or the next attempt; None without one.
        left: Seconds that were left to the deadline when it was paused.
        counts: For each `repeat`, by its place: how often its steps were run.
        mark: The mark that was reached last.
        answer: The last answer.
        ended: For each step that ended, its place and whether it succeeded, the latest 200.
    """

    entry: Entry
    phase: Phase = Phase.WAITING
    at: int = 0
    aborting: bool = False
    charging: bool = False
    paused: bool = False
    reason: str = ""
    question: Question | None = None
    attempt: int = 0
    token: int = 0
    begun: bool = False
    deadline: float | None = None
    left: float | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    mark: str = ""
    answer: str = ""
    ended: tuple[tuple[int, bool], ...] = ()

    @property
    def steps(self) -> tuple[Step, ...]:
        """The list that `at` counts in."""
        return self.entry.mission.on_abort if self.aborting else self.entry.mission.steps


@dataclass(frozen=True, slots=True)
class Notice:
    """One event for people and webhooks.

    Attributes:
        number: Grows by one with each.
        at: Seconds since 1970, for people.
        kind: "start", "step", "waiting", "question", "answer", "pause", "resume", "interrupted", "end", "queue".
        run: The id of the run; "" for the queue.
        mission: Its name.
        step: The place of the step, from 0; -1 without one.
        text: In words.
        values: Its facts, for programs.
    """

    number: int
    at: float
    kind: str
    run: str = ""
    mission: str = ""
    step: int = -1
    text: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class State:
    """Everything that is kept on disk for one robot.

    Attributes:
        queue: What comes next.
        paused: Whether the queue is paused: by a person, or since a stop.
        run: The current run, or the last one that ended.
        history: The last 50 runs that ended before it, without their steps' questions.
        next_id: Of the next entry.
        notices: The last 500.
        delivered: The number of the last notice that the webhook has taken.
        disk: Why the state cannot be kept on disk; nothing begins meanwhile. "" if it can.
    """

    queue: tuple[Entry, ...] = ()
    paused: bool = False
    run: Run | None = None
    history: tuple[Run, ...] = ()
    next_id: int = 1
    notices: tuple[Notice, ...] = ()
    delivered: int = 0
    disk: str = ""

    @property
    def active(self) -> bool:
        """Whether a run has not ended."""
        return self.run is not None and not self.run.phase.over


class Refused(MissionError):
    """What was asked for is not possible in this state; nothing has changed."""


# -- effects -------------------------------------------------------------------------------------------------


class Carry(NamedTuple):
    """Carry a step out; ends with one `StepEnded` of this token."""

    token: int
    step: Step
    parameters: Mapping[str, Value]


class Cancel(NamedTuple):
    """Cancel what `Carry` has begun."""

    token: int


class Hold(NamedTuple):
    """Pause what `Carry` has begun, if it can be paused."""

    token: int


class GoOn(NamedTuple):
    """Resume what was held."""

    token: int


Effect = Carry | Cancel | Hold | GoOn
