"""The machine of missions: `step` takes a state and an event (a name and its values), and returns the next
state. Pure: no clock, threads or network; `now` is any clock that never goes back, `at` is for people.

`Phase` and `NEXT` are the table of a run; `paused` is beside it: nothing begins while it is set. What the
driver carries out follows from the state: while the phase is "running" the current step, once for each token.

The start of a program moves nothing: a run that was under way is interrupted, and the queue is paused. When
it is resumed, the step that may have begun is "not known", and a question with `UNKNOWN_ANSWERS` follows,
unless `settled` came. A stop by anybody ends the run and pauses the queue; `on_abort` steps follow a failure
only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from enum import Enum
from typing import Any

from rosproto.sentence import say
from woosh_pure.missions.mission import MOVING, Mission, MissionError, Step, Value, mission_of

MAX_QUEUE, MAX_HISTORY, MAX_NOTICES, MAX_ENDED = 50, 50, 500, 200
_MAX_TURNS = 250


class Phase(str, Enum):
    """What a run is doing."""

    WAITING = "waiting"
    """Between two steps: `reason` says what for, such as the robot's readiness."""
    RUNNING = "running"
    RETRYING = "retrying"
    ASKING = "asking"
    INTERRUPTED = "interrupted"
    """The program ended; a person or program resumes it."""
    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"

    def __str__(self) -> str:
        """Its word, on every Python."""
        return self.value

    @property
    def over(self) -> bool:
        """Whether the run has ended."""
        return not NEXT[self]


_ALWAYS = (Phase.INTERRUPTED, Phase.STOPPED)
NEXT: Mapping[Phase, tuple[Phase, ...]] = {
    Phase.WAITING: (Phase.RUNNING, Phase.ASKING, Phase.DONE, Phase.FAILED, *_ALWAYS),
    Phase.RUNNING: (Phase.WAITING, Phase.RETRYING, Phase.ASKING, Phase.DONE, Phase.FAILED, *_ALWAYS),
    Phase.RETRYING: (Phase.WAITING, *_ALWAYS),
    Phase.ASKING: (Phase.WAITING, Phase.DONE, Phase.FAILED, *_ALWAYS),
    Phase.INTERRUPTED: (Phase.WAITING, Phase.RETRYING, Phase.ASKING, Phase.DONE, Phase.FAILED, *_ALWAYS),
    Phase.DONE: (),
    Phase.FAILED: (),
    Phase.STOPPED: (),
}
"""Which phases may follow. A new run is waiting."""
HARMLESS = ("wait", "wait_for_input", "wait_for_battery", "if", "ask")
"""Steps that may be begun again without a question, because they do nothing."""
UNKNOWN_ANSWERS = ("done", "again", "stop")
"""To the question what became of a step that was running when the program ended."""


class Result(Enum):
    """How a step ended."""

    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"
    """By somebody else."""
    UNKNOWN = "not known"
    """The robot may still be carrying it out."""


class Refused(MissionError):
    """What was asked for is not possible in this state; nothing has changed."""

    exit_code = 3


@dataclass(frozen=True, slots=True)
class Entry:
    """A mission in the queue, with a copy of its steps: a file that changes later does not matter.

    Attributes:
        id: Its number, as text; the run has the same.
    """

    id: str
    mission: Mission
    parameters: Mapping[str, Value] = field(default_factory=dict)
    by: str = ""
    file: str = ""

    def to_json(self) -> dict[str, Any]:
        """Its mission is as in a file."""
        return {**asdict(self), "mission": self.mission.data()}


@dataclass(frozen=True, slots=True)
class Question:
    """A question to a person; `unknown` if it asks what became of a step."""

    text: str
    answers: tuple[str, ...]
    default: str = ""
    unknown: bool = False


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a mission.

    Attributes:
        at: The place of the current step in `steps`, from 0.
        paused: Nothing begins until it is resumed.
        reason: Why it waits or how it ended, in words.
        failure: Why the mission has failed; its `on_abort` steps are carried out then. "" otherwise.
        charging: A guard has inserted charging before the current step.
        attempt: Failures of the current step so far.
        token: Of what was begun last; it grows.
        begun: Whether that may be under way, or its end is not known.
        task, after: The robot's id of its task, 0 without one; the time of that id in the robot's history
            before.
        deadline: In the machine's time, of the question or the next attempt; None without one.
        counts: How often the steps of each `repeat` were run, by its place.
        mark, answer: The last ones.
        ended: Place and success of each step that ended, the last 200.
    """

    entry: Entry
    phase: Phase = Phase.WAITING
    at: int = 0
    paused: bool = False
    reason: str = ""
    failure: str = ""
    charging: bool = False
    question: Question | None = None
    attempt: int = 0
    token: int = 0
    begun: bool = False
    task: int = 0
    after: float = -1.0
    deadline: float | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    mark: str = ""
    answer: str = ""
    ended: tuple[tuple[int, bool], ...] = ()

    @property
    def steps(self) -> tuple[Step, ...]:
        """The list of `at`: those of the mission, or of `on_abort` after its failure."""
        return self.entry.mission.on_abort if self.failure else self.entry.mission.steps

    @property
    def step(self) -> Step | None:
        """The current step, also that of a guard; None at the end."""
        if self.charging:
            guard = self.entry.mission.guard
            return Step("charge", {"mark": guard("charger"), "until_percent": guard("charge_until")})
        return self.steps[self.at] if self.at < len(self.steps) else None

    def value(self, key: str) -> Any:
        """A key of the current step, with the parameters of the run."""
        assert self.step is not None
        return self.step.value(key, self.entry.parameters)

    def to_json(self) -> dict[str, Any]:
        """For disk and clients."""
        return {**asdict(self), "entry": self.entry.to_json()}


@dataclass(frozen=True, slots=True)
class Notice:
    """One event for people and webhooks.

    Attributes:
        number: Grows by one with each.
        at: Seconds since 1970, for people.
        kind: "start", "step", "waiting", "question", "answer", "pause", "resume", "interrupted", "end" or
            "queue".
        run: The id of the run; "" for the queue.
        step: The place of the step, from 0; -1 without one.
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
        paused: Whether the queue is paused: by a person, since a stop, or since a start of the program.
        runs: The last ones, the current one at the end; those before it without their steps.
        notices: The last 500.
        delivered: The number of the last notice that the webhook has taken.
        disk: Why the state cannot be kept; nothing begins meanwhile. "" if it can.
    """

    queue: tuple[Entry, ...] = ()
    paused: bool = False
    runs: tuple[Run, ...] = ()
    next_id: int = 1
    notices: tuple[Notice, ...] = ()
    delivered: int = 0
    disk: str = ""

    @property
    def run(self) -> Run | None:
        """The current run, or the last one."""
        return self.runs[-1] if self.runs else None

    @property
    def active(self) -> Run | None:
        """The run that has not ended."""
        return None if self.run is None or self.run.phase.over else self.run

    @property
    def running(self) -> Run | None:
        """The run whose current step is to be carried out."""
        return self.run if self.run is not None and self.run.phase is Phase.RUNNING else None

    @property
    def needs_ready(self) -> bool:
        """Whether the current step waits for `ready`."""
        run = self.active
        waits = run is not None and run.phase is Phase.WAITING and not run.paused and not self.disk
        return waits and run is not None and run.step is not None and run.step.do in MOVING

    def to_json(self) -> dict[str, Any]:
        """As it is kept on disk; `state_of` is the way back."""
        kept: dict[str, Any] = {"paused": self.paused, "next_id": self.next_id, "delivered": self.delivered}
        return kept | {
            "queue": [entry.to_json() for entry in self.queue],
            "runs": [run.to_json() for run in self.runs],
            "notices": [asdict(notice) for notice in self.notices],
        }


def state_of(data: Mapping[str, Any]) -> State:
    """Read what `to_json` has written.

    Raises:
        ValueError, KeyError, TypeError: It is something else.
    """
    queue, runs = tuple(map(_entry_of, data["queue"])), tuple(map(_run_of, data["runs"]))
    notices = tuple(Notice(**each) for each in data["notices"])
    return State(**{**data, "queue": queue, "runs": runs, "notices": notices})


def _entry_of(data: Mapping[str, Any]) -> Entry:
    given = data["mission"]  # of the history without steps
    return Entry(**{**data, "mission": mission_of(given) if "step" in given else Mission(given["name"], ())})


def _run_of(data: Mapping[str, Any]) -> Run:
    asked, ended = data["question"], tuple((int(at), bool(ok)) for at, ok in data["ended"])
    question = asked and Question(**{**asked, "answers": tuple(asked["answers"])})
    entry, phase = _entry_of(data["entry"]), Phase(data["phase"])
    return Run(**{**data, "entry": entry, "phase": phase, "question": question, "ended": ended})


REQUESTS = ("append", "change_queue", "pause", "resume", "stop", "answer")
"""The events that people and programs ask for."""


def step(state: State, event: str, now: float, at: float, **values: Any) -> State:
    """Return the state after an event: `on_...` of `_Change`, with these values. It is saved before a step
    begins.

    Raises:
        Refused: It is not possible now.
    """
    change = _Change(state, now, at)
    getattr(change, f"on_{event}")(**values)
    change.follow()
    return change.state


class _Change:
    """A state that is being changed."""

    def __init__(self, state: State, now: float, at: float) -> None:
        self.state, self.now, self.at = state, now, at

    @property
    def run(self) -> Run:
        assert self.state.run is not None
        return self.state.run

    def set(self, phase: Phase | None = None, **changes: Any) -> None:
        """Change the run. Its question and deadline belong to one phase."""
        before = self.run
        if phase is not None:
            assert phase is before.phase or phase in NEXT[before.phase], (before.phase, phase)
            changes = {"phase": phase, "question": None, "deadline": None, "reason": ""} | changes
        self.state = replace(self.state, runs=(*self.state.runs[:-1], replace(before, **changes)))

    def note(self, kind: str, text: str = "", **values: object) -> None:
        run, notices = None if kind == "queue" else self.state.run, self.state.notices
        about = ("", "", -1) if run is None else (run.entry.id, run.entry.mission.name, run.at)
        notice = Notice(notices[-1].number + 1 if notices else 1, self.at, kind, *about, text, values)
        self.state = replace(self.state, notices=(*notices, notice)[-MAX_NOTICES:])

    # -- what follows

    def follow(self) -> None:
        """Go on until something must be waited for."""
        for _ in range(_MAX_TURNS):
            state, run = self.state, self.state.active
            if state.disk:
                return
            if run is None:
                if state.paused or not state.queue:
                    return
                self.state = replace(state, queue=state.queue[1:])
                self.start(state.queue[0])
                continue
            current = run.step
            if run.phase is not Phase.WAITING or run.paused:
                return
            if current is None:
                self.end(Phase.FAILED if run.failure else Phase.DONE, run.failure)
            elif current.do == "ask":
                self.ask(current)
                return
            elif current.do == "if" and current.value("value") in ("mark", "answer"):
                self.decide(run.mark if current.value("value") == "mark" else run.answer)
            elif current.do == "repeat":
                self.repeat()
            elif current.do == "go_on":
                self.go(current.value("with"))
            else:
                if current.do not in MOVING:
                    self.begin()
                return
        if self.state.active:
            self.fail(say("its steps lead round and round, and nothing is done"))

    def start(self, entry: Entry) -> None:
        runs = self.state.runs
        if before := self.state.run:
            past = replace(before.entry, mission=Mission(before.entry.mission.name, ()))
            runs = (*runs[:-1], replace(before, entry=past))[-MAX_HISTORY:]
        self.state = replace(self.state, runs=(*runs, Run(entry, token=before.token if before else 0)))
        self.note("start", by=entry.by, parameters=dict(entry.parameters))

    def begin(self) -> None:
        current = self.run.step
        assert current is not None
        self.set(Phase.RUNNING, token=self.run.token + 1, begun=True, task=0)
        self.note("step", current.do, do=current.do, name=current.name)

    def ask(self, current: Step) -> None:
        answers = tuple(current.value("answers"))
        asked = Question(self.run.value("text"), answers, current.value("default"))
        deadline = self.now + current.timeout if current.timeout else None
        self.set(Phase.ASKING, question=asked, deadline=deadline)
        self.note("question", asked.text, answers=list(answers))

    def ask_unknown(self, reason: str = "") -> None:
        do = "" if self.run.step is None else self.run.step.do
        ask = "What became of step {number} ({do}) is not known. Was it done?"
        text = say(ask, number=self.run.at + 1, do=do)
        self.set(Phase.ASKING, question=Question(text, UNKNOWN_ANSWERS, unknown=True), reason=reason)
        self.note("question", text, answers=list(UNKNOWN_ANSWERS))

    def repeat(self) -> None:
        run, times = self.run, self.run.value("times")
        count = run.counts.get(str(run.at), 0) + 1
        again = not times or count < times
        self.set(counts={**run.counts, str(run.at): count if again else 0})
        self.go(run.value("from") if again else "next")

    def decide(self, value: object) -> None:
        """Go on from an `if` with the value that was read."""
        below, above, wanted = map(self.run.value, ("below", "above", "is"))
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            met = above < value < below
        else:
            met = wanted == (("off", "on")[value] if isinstance(value, bool) else value)
        self.go(self.run.value("then" if met else "else"))

    def go(self, target: str) -> None:
        """Go on with a target; the current step is over."""
        run = self.run
        self.set(Phase.WAITING, attempt=0, begun=False)
        if target == "next":
            self.set(at=run.at + 1)
        elif target == "end":
            self.end(Phase.DONE)
        elif target == "stop":
            self.fail(say("step {number} led to stop", number=run.at + 1))
        else:
            self.set(at=run.entry.mission.index(target))

    def step_done(self, ok: bool, text: str = "", value: float | bool | None = None) -> None:
        run, current = self.run, self.run.step
        assert current is not None
        if run.charging:
            self.set(Phase.WAITING, charging=False, begun=False)
            if not ok:
                self.fail(text)
            return
        self.set(ended=(*run.ended, (run.at, ok))[-MAX_ENDED:])
        if ok and "mark" in current.values:
            self.set(mark=run.value("mark"))
        if ok and current.do == "if":
            self.decide(value)
        elif ok or run.failure:
            self.go("next")
        elif run.attempt < current.retries:
            deadline = self.now + current.retry_pause
            self.set(Phase.RETRYING, attempt=run.attempt + 1, begun=False, deadline=deadline, reason=text)
        elif current.on_failure == "stop":
            self.set(Phase.WAITING, begun=False)
            self.fail(text)
        else:
            self.go(current.on_failure)

    def fail(self, text: str) -> None:
        if not self.run.failure:
            why = text or say("a step failed")
            if not self.run.entry.mission.on_abort:
                self.end(Phase.FAILED, why)
                return
            self.set(Phase.WAITING, failure=why, at=0, attempt=0)

    def end(self, phase: Phase, text: str = "") -> None:
        """End the run. The queue goes on only after one that is done."""
        if phase is not Phase.DONE:
            self.state = replace(self.state, paused=True)
        self.set(phase, reason=text, begun=False, paused=False)
        self.note("end", text, phase=phase.value)

    # -- events: what people and programs ask for

    def on_append(
        self, mission: Mission, parameters: Mapping[str, Value], by: str, file: str = "", start: bool = False
    ) -> None:
        """Append a mission to the queue, or start it at once."""
        state = self.state
        if start and state.active:
            text = "{name} has not ended; append yours to the queue, or stop that one"
            raise Refused(say(text, name=state.active.entry.mission.name))
        if state.disk:
            raise Refused(state.disk)
        if len(state.queue) >= MAX_QUEUE:
            raise Refused(say("the queue has {count} missions already, which is the limit", count=MAX_QUEUE))
        entry = Entry(str(state.next_id), mission, parameters, by, file)
        self.state = replace(state, next_id=state.next_id + 1)
        if start:
            self.start(entry)
        else:
            self.set_queue([*state.queue, entry], by)

    def on_change_queue(self, by: str, id: str = "", place: int | None = None) -> None:
        """Remove an entry, move it to a place, or without an id remove all."""
        found = [entry for entry in self.state.queue if entry.id == id]
        if id and not found:
            raise Refused(say("no mission {id} is in the queue", id=id))
        queue = [entry for entry in self.state.queue if id and entry.id != id]
        if place is not None:
            queue[max(0, place) : max(0, place)] = found
        self.set_queue(queue, by)

    def set_queue(self, queue: list[Entry], by: str) -> None:
        self.state = replace(self.state, queue=tuple(queue))
        self.note("queue", by=by, queue=[entry.id for entry in queue])

    def on_pause(self, by: str) -> None:
        """A person or program pauses run and queue."""
        self.state = replace(self.state, paused=True)
        if self.state.active:
            self.set(paused=True)
        self.note("pause", by=by)

    def on_resume(self, by: str) -> None:
        """A person or program lets run and queue go on."""
        self.state = replace(self.state, paused=False)
        self.note("resume", by=by)
        if self.state.active:
            self.set(paused=False)
            if self.run.phase is Phase.INTERRUPTED and self.run.begun:
                self.ask_unknown()
            elif self.run.phase is Phase.INTERRUPTED:
                self.set(Phase.WAITING)

    def on_stop(self, by: str) -> None:
        """Somebody has stopped the robot, or wants the run to end."""
        self.state = replace(self.state, paused=True)
        if self.state.active:
            self.end(Phase.STOPPED, say("stopped by {who}", who=by))

    def on_answer(self, answer: str, by: str, run: str = "") -> None:
        """An answer to the question; `run` is the id of its run, or "" for any."""
        asked = self.state.active if self.state.active and run in ("", self.run.entry.id) else None
        if asked is None or (question := asked.question) is None:
            raise Refused(say("there is no question to answer"))
        if answer not in question.answers:
            names = list(question.answers)
            raise Refused(say("{answer!r}: expected one of: {names}", answer=answer, names=names))
        self.note("answer", answer, by=by)
        if not question.unknown:
            self.set(answer=answer)
            self.go(asked.value("answers")[answer])
        elif answer == "stop":
            self.on_stop(by)
        elif answer == "again":
            self.set(Phase.WAITING, begun=False)
        else:
            self.step_done(True)

    # -- events: what the driver tells

    def on_ready(self, reason: str, battery: float | None = None) -> None:
        """The readiness of the robot: `reason` is "" if it is ready; `battery` is None if it is not known."""
        run = self.state.run
        if run is None or run.step is None or not self.state.needs_ready:
            return
        if reason:
            if reason != run.reason:
                self.set(reason=reason)
                self.note("waiting", reason)
            return
        # Only before a step that finds its way from the charger: a relative one would begin elsewhere.
        finds = not {"mark", "x", "list"}.isdisjoint(run.step.keys)
        low = run.entry.mission.guard("battery_below")
        if finds and battery is not None and battery < low and not run.failure:
            self.set(charging=True)
        self.begin()

    def _under_way(self, token: int, phase: Phase) -> bool:
        """Whether the step of a token is under way; a run that was stopped does not hear of its end."""
        return self.state.active is not None and (self.run.phase, self.run.token) == (phase, token)

    def on_step_ended(
        self, token: int, result: Result, text: str = "", value: float | bool | None = None
    ) -> None:
        """The end of a step; `value` of one that reads something."""
        if not self._under_way(token, Phase.RUNNING):
            return
        if result is Result.STOPPED:
            self.on_stop(text or say("somebody else"))
        elif result is Result.UNKNOWN:
            self.set(paused=False)
            self.ask_unknown(text)
        else:
            self.step_done(result is Result.DONE, text, value)

    def on_sent(self, token: int, task: int, after: float = -1.0) -> None:
        """The robot has a task of this step, with its id, or will have it; see `Run`."""
        if self._under_way(token, Phase.RUNNING):
            self.set(task=task, after=after)

    def on_settled(self, token: int, done: bool) -> None:
        """The robot's history tells how the step that was interrupted has ended. Nothing begins by it."""
        if self._under_way(token, Phase.INTERRUPTED) and self.run.begun:
            self.set(paused=True)
            self.step_done(done, say("the robot says that it failed"))

    def on_tick(self) -> None:
        """Time has passed."""
        run = self.state.active
        if run is None or run.deadline is None or run.paused or self.now < run.deadline:
            return
        if run.phase is Phase.RETRYING:
            self.set(Phase.WAITING)
        elif run.question is not None:
            self.on_answer(run.question.default, say("the time limit"))

    def on_restarted(self, carries: bool = True) -> None:
        """The program has started with this state, from disk; without `carries` nothing begins in it."""
        paused = self.state.paused or bool(self.state.queue) or not carries
        self.state, run = replace(self.state, paused=paused), self.state.active
        if run is not None and run.phase is not Phase.INTERRUPTED:
            harmless = run.step is None or run.step.do in HARMLESS
            self.set(Phase.INTERRUPTED, begun=run.begun and not harmless, paused=False)
            self.state = replace(self.state, paused=True)
            self.note("interrupted", say("interrupted at step {number}", number=run.at + 1))

    def on_delivered(self, number: int) -> None:
        """The webhook has taken the notices up to this number."""
        self.state = replace(self.state, delivered=max(self.state.delivered, number))

    def on_disk(self, problem: str) -> None:
        """The state cannot be kept on disk, or ("") can again."""
        self.state = replace(self.state, disk=problem)
