"""The machine of missions: `step` takes a state and an event, and returns the next state and the effects.
Pure: no clock, threads or network; `now` is any clock that never goes back, `at` is for people.

`Phase` and `NEXT` are the table of a run; `paused` is beside it: nothing begins while it is set. The start of
a program moves nothing: a run that was under way is interrupted, and the queue is paused. When it is resumed,
the step that may have begun is "not known", and a question with `UNKNOWN_ANSWERS` follows, unless `Settled`
came. A stop by anybody ends the run and pauses the queue; `on_abort` steps follow a failure only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple

from rosproto.sentence import say
from woosh_pure.missions.mission import Mission, MissionError, Step, Value, mission_of

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
        task: The robot's id of its task, 0 without one.
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
        run: The current run, or the last one.
        history: Runs that ended before it, without their steps.
        notices: The last 500.
        delivered: The number of the last notice that the webhook has taken.
        disk: Why the state cannot be kept; nothing begins meanwhile. "" if it can.
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

    def to_json(self) -> dict[str, Any]:
        """As it is kept on disk; `state_of` is the way back."""
        runs = [run_json(run) for run in (*self.history, *((self.run,) if self.run else ()))]
        plain = {"paused": self.paused, "next_id": self.next_id, "delivered": self.delivered}
        notices = [asdict(notice) for notice in self.notices]
        return {"queue": [entry_json(e) for e in self.queue], "runs": runs, "notices": notices, **plain}


def state_of(data: Mapping[str, Any]) -> State:
    """Read what `to_json` has written.

    Raises:
        ValueError, KeyError, TypeError: It is something else.
    """
    runs = tuple(_run_of(each) for each in data["runs"])
    notices = tuple(Notice(**each) for each in data["notices"])
    queue, plain = tuple(map(_entry_of, data["queue"])), ("paused", "next_id", "delivered")
    run = runs[-1] if runs else None
    return State(queue, run=run, history=runs[:-1], notices=notices, **{key: data[key] for key in plain})


def entry_json(entry: Entry) -> dict[str, Any]:
    """An entry as JSON, its mission as in a file."""
    return {**asdict(entry), "mission": entry.mission.data()}


def _entry_of(data: Mapping[str, Any]) -> Entry:
    given = data["mission"]
    past = {"name": given["name"], "steps": ()}  # of the history
    return Entry(**{**data, "mission": mission_of(given) if "step" in given else Mission(**past)})


def run_json(run: Run) -> dict[str, Any]:
    """A run as JSON, for disk and clients."""
    return {**asdict(run), "entry": entry_json(run.entry)}


def _run_of(data: Mapping[str, Any]) -> Run:
    asked = data["question"]
    return Run(
        **{
            **data,
            "entry": _entry_of(data["entry"]),
            "phase": Phase(data["phase"]),
            "question": asked and Question(**{**asked, "answers": tuple(asked["answers"])}),
            "ended": tuple((int(at), bool(ok)) for at, ok in data["ended"]),
        }
    )


class Refused(MissionError):
    """What was asked for is not possible in this state; nothing has changed."""

    exit_code = 3


# -- events and effects --------------------------------------------------------------------------------------


class Append(NamedTuple):
    """Append a mission to the queue, or start it at once."""

    mission: Mission
    parameters: Mapping[str, Value]
    by: str
    file: str = ""
    start: bool = False


class ChangeQueue(NamedTuple):
    """Remove an entry, move it to a place, or without an id remove all."""

    by: str
    id: str = ""
    place: int | None = None


class Pause(NamedTuple):
    """A person or program pauses run and queue."""

    by: str


class Resume(NamedTuple):
    """A person or program lets run and queue go on."""

    by: str


class Stop(NamedTuple):
    """Somebody has stopped the robot, or wants the run to end."""

    by: str


class Answer(NamedTuple):
    """An answer to the question; `run` is the id of its run, or "" for any."""

    answer: str
    by: str
    run: str = ""


class Ready(NamedTuple):
    """The readiness of the robot: `reason` is "" if it is ready; `battery` in percent, None if not known."""

    reason: str
    battery: float | None = None


class Result(Enum):
    """How a step ended."""

    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"
    """By somebody else."""
    UNKNOWN = "not known"
    """The robot may still be carrying it out."""


class StepEnded(NamedTuple):
    """The end of what `Carry` has begun; `value` of a step that reads one."""

    token: int
    result: Result
    text: str = ""
    value: float | bool | None = None


class Sent(NamedTuple):
    """The robot has a task of this step, with its id."""

    token: int
    task: int


class Settled(NamedTuple):
    """The robot's history tells how the step that was interrupted has ended."""

    token: int
    done: bool


class Tick(NamedTuple):
    """Time has passed."""


class Restarted(NamedTuple):
    """The program has started with this state, from disk; without `carries` nothing begins in it."""

    carries: bool = True


class Delivered(NamedTuple):
    """The webhook has taken the notices up to this number."""

    number: int


class Disk(NamedTuple):
    """The state cannot be kept on disk, or ("") can again."""

    problem: str


Event = (
    Append | ChangeQueue | Pause | Resume | Stop | Answer | Ready | StepEnded | Sent | Settled | Tick
    | Restarted | Delivered | Disk
)  # fmt: skip


class Carry(NamedTuple):
    """Carry a step out; ends with one `StepEnded` of this token."""

    token: int
    step: Step
    parameters: Mapping[str, Value]


class Cancel(NamedTuple):
    """Cancel what `Carry` has begun. It comes before the state is saved."""

    token: int


class Hold(NamedTuple):
    """Pause what `Carry` has begun if it can be paused, or let it go on."""

    token: int
    held: bool


Effect = Carry | Cancel | Hold


def step(state: State, event: Event, now: float, at: float) -> tuple[State, list[Effect]]:
    """Return the state after an event, and its effects. The state is saved before a `Carry` is begun.

    Raises:
        Refused: It is not possible now.
    """
    change = _Change(state, now, at)
    _EVENTS[type(event)](change, event)
    change.follow()
    return change.state, change.effects


class _Change:
    """A state that is being changed."""

    def __init__(self, state: State, now: float, at: float) -> None:
        self.state, self.now, self.at = state, now, at
        self.effects: list[Effect] = []

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
        self.state = replace(self.state, run=replace(before, **changes))

    def note(self, kind: str, text: str = "", **values: object) -> None:
        run = None if kind == "queue" else self.state.run
        number = self.state.notices[-1].number + 1 if self.state.notices else 1
        about = ("", "", -1) if run is None else (run.entry.id, run.entry.mission.name, run.at)
        notice = Notice(number, self.at, kind, *about, text, values)
        self.state = replace(self.state, notices=(*self.state.notices, notice)[-MAX_NOTICES:])

    def follow(self) -> None:
        """Go on until something must be waited for."""
        for _ in range(_MAX_TURNS):
            state, run = self.state, self.state.run
            if state.disk:
                return
            if run is None or run.phase.over:
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
                self.decide(current, run.mark if current.value("value") == "mark" else run.answer)
            elif current.do in ("repeat", "go_on"):
                self.turn(current)
            else:
                if not current.kind.moves:
                    self.begin()
                return
        if self.state.active:
            self.fail(say("its steps lead round and round, and nothing is done"))

    def start(self, entry: Entry) -> None:
        before = self.state.run
        if before is not None:
            past = replace(
                before, entry=replace(before.entry, mission=Mission(before.entry.mission.name, ()))
            )
            self.state = replace(self.state, history=(*self.state.history, past)[-MAX_HISTORY:])
        self.state = replace(self.state, run=Run(entry, token=0 if before is None else before.token))
        self.note("start", by=entry.by, parameters=dict(entry.parameters))

    def begin(self) -> None:
        run, current = self.run, self.run.step
        assert current is not None
        self.set(Phase.RUNNING, token=run.token + 1, begun=True, task=0)
        self.note("step", current.do, do=current.do, name=current.name)
        self.effects.append(Carry(run.token + 1, current, run.entry.parameters))

    def ask(self, current: Step) -> None:
        answers, parameters = tuple(current.value("answers")), self.run.entry.parameters
        asked = Question(current.value("text", parameters), answers, current.value("default"))
        self.set(
            Phase.ASKING, question=asked, deadline=self.now + current.timeout if current.timeout else None
        )
        self.note("question", asked.text, answers=list(answers))

    def ask_unknown(self, reason: str = "") -> None:
        current = self.run.step
        do = "" if current is None else current.do
        text = say(
            "What became of step {number} ({do}) is not known. Was it done?", number=self.run.at + 1, do=do
        )
        self.set(Phase.ASKING, question=Question(text, UNKNOWN_ANSWERS, unknown=True), reason=reason)
        self.note("question", text, answers=list(UNKNOWN_ANSWERS))

    def turn(self, current: Step) -> None:
        if current.do == "go_on":
            self.go(current.value("with"))
            return
        place, times = str(self.run.at), current.value("times", self.run.entry.parameters)
        count = self.run.counts.get(place, 0) + 1
        again = not times or count < times
        self.set(counts={**self.run.counts, place: count if again else 0})
        self.go(current.value("from") if again else "next")

    def decide(self, current: Step, value: object) -> None:
        """Go on from an `if` with the value that was read."""
        below, above, wanted = (
            current.value(key, self.run.entry.parameters) for key in ("below", "above", "is")
        )
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            met = above < value < below
        else:
            met = wanted == (("off", "on")[value] if isinstance(value, bool) else value)
        self.go(current.value("then" if met else "else"))

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
            self.set(mark=current.value("mark", run.entry.parameters))
        if ok and current.do == "if":
            self.decide(current, value)
        elif ok or run.failure:
            self.go("next")
        elif run.attempt < current.retries:
            self.set(
                Phase.RETRYING,
                attempt=run.attempt + 1,
                begun=False,
                deadline=self.now + current.retry_pause,
                reason=text,
            )
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
        """End the run. The queue goes on only after one that is done: a stop can look like a failure."""
        if phase is not Phase.DONE:
            self.state = replace(self.state, paused=True)
        self.set(phase, reason=text, begun=False, paused=False)
        self.note("end", text, phase=phase.value)


# -- what each event does ------------------------------------------------------------------------------------


def _append(change: _Change, event: Append) -> None:
    state = change.state
    entry = Entry(str(state.next_id), event.mission, event.parameters, event.by, event.file)
    if event.start and state.active:
        name = change.run.entry.mission.name
        raise Refused(say("{name} has not ended; append yours to the queue, or stop that one", name=name))
    if state.disk:
        raise Refused(state.disk)
    if len(state.queue) >= MAX_QUEUE:
        raise Refused(say("the queue has {count} missions already, which is the limit", count=MAX_QUEUE))
    change.state = replace(state, next_id=state.next_id + 1)
    if event.start:
        change.start(entry)
    else:
        change.state = replace(change.state, queue=(*state.queue, entry))
        change.note("queue", entry.mission.name, by=event.by, queue=[e.id for e in change.state.queue])


def _queue(change: _Change, event: ChangeQueue) -> None:
    queue = list(change.state.queue)
    found = [entry for entry in queue if entry.id == event.id]
    if event.id and not found:
        raise Refused(say("no mission {id} is in the queue", id=event.id))
    queue = [entry for entry in queue if event.id and entry.id != event.id]
    if event.place is not None:
        queue[max(0, event.place) : max(0, event.place)] = found
    change.state = replace(change.state, queue=tuple(queue))
    change.note("queue", by=event.by, queue=[entry.id for entry in queue])


def _pause(change: _Change, event: Pause) -> None:
    change.state = replace(change.state, paused=True)
    if change.state.active and not change.run.paused:
        change.set(paused=True)
        if change.run.phase is Phase.RUNNING:
            change.effects.append(Hold(change.run.token, True))
    change.note("pause", by=event.by)


def _resume(change: _Change, event: Resume) -> None:
    change.state = replace(change.state, paused=False)
    change.note("resume", by=event.by)
    if not change.state.active:
        return
    held = change.run.paused
    change.set(paused=False)
    if change.run.phase is Phase.INTERRUPTED and change.run.begun:
        change.ask_unknown()
    elif change.run.phase is Phase.INTERRUPTED:
        change.set(Phase.WAITING)
    elif held and change.run.phase is Phase.RUNNING:
        change.effects.append(Hold(change.run.token, False))


def _stop(change: _Change, event: Stop) -> None:
    change.state = replace(change.state, paused=True)
    if change.state.active:
        if change.run.phase is Phase.RUNNING:
            change.effects.append(Cancel(change.run.token))
        change.end(Phase.STOPPED, say("stopped by {who}", who=event.by))


def _answer(change: _Change, event: Answer) -> None:
    run = change.state.run
    question = None if run is None or event.run not in ("", run.entry.id) else run.question
    if run is None or question is None:
        raise Refused(say("there is no question to answer"))
    if event.answer not in question.answers:
        raise Refused(
            say("{answer!r}: expected one of: {names}", answer=event.answer, names=list(question.answers))
        )
    change.note("answer", event.answer, by=event.by)
    current = run.step
    assert current is not None
    if not question.unknown:
        change.set(answer=event.answer)
        change.go(current.value("answers")[event.answer])
    elif event.answer == "stop":
        _stop(change, Stop(event.by))
    elif event.answer == "again":
        change.set(Phase.WAITING, begun=False)
    else:
        change.step_done(True)


def _ready(change: _Change, event: Ready) -> None:
    state, run = change.state, change.state.run
    if run is None or run.phase is not Phase.WAITING or run.paused or state.disk or not needs_ready(state):
        return
    if event.reason:
        if event.reason != run.reason:
            change.set(reason=event.reason)
            change.note("waiting", event.reason)
        return
    # Only before a step that finds its way from the charger: a relative one would begin at the wrong place.
    finds = run.step is not None and not {"mark", "x"}.isdisjoint(run.step.kind.keys)
    low = run.entry.mission.guard("battery_below")
    if finds and event.battery is not None and event.battery < low and not run.failure:
        change.set(charging=True)
    change.begin()


def needs_ready(state: State) -> bool:
    """Whether the current step waits for a `Ready`."""
    run = state.run
    waits = run is not None and run.phase is Phase.WAITING and not run.paused
    return waits and run is not None and run.step is not None and run.step.kind.moves


def _step_ended(change: _Change, event: StepEnded) -> None:
    run = change.state.run
    if run is None or run.phase is not Phase.RUNNING or run.token != event.token:
        return  # the run was stopped
    if event.result is Result.STOPPED:
        _stop(change, Stop(event.text or say("somebody else")))
    elif event.result is Result.UNKNOWN:
        change.set(paused=False)
        change.ask_unknown(event.text)
    else:
        change.step_done(event.result is Result.DONE, event.text, event.value)


def _sent(change: _Change, event: Sent) -> None:
    if change.state.active and change.run.token == event.token:
        change.set(task=event.task)


def _settled(change: _Change, event: Settled) -> None:
    """Before a `Resume`: nothing begins here."""
    run = change.state.run
    if run is not None and run.phase is Phase.INTERRUPTED and run.begun and run.token == event.token:
        change.set(paused=True)
        change.step_done(event.done, say("the robot says that it failed"))


def _tick(change: _Change, event: Tick) -> None:
    run = change.state.run
    if run is None or run.deadline is None or run.paused or change.now < run.deadline:
        return
    if run.phase is Phase.RETRYING:
        change.set(Phase.WAITING)
    elif run.question is not None:
        _answer(change, Answer(run.question.default, say("the time limit")))


def _restarted(change: _Change, event: Restarted) -> None:
    change.state = replace(
        change.state, paused=change.state.paused or bool(change.state.queue) or not event.carries
    )
    if change.state.active and change.run.phase is not Phase.INTERRUPTED:
        run, current = change.run, change.run.step
        harmless = current is None or current.do in HARMLESS
        change.set(Phase.INTERRUPTED, begun=run.begun and not harmless, paused=False)
        change.state = replace(change.state, paused=True)
        change.note("interrupted", say("interrupted at step {number}", number=run.at + 1))


_EVENTS: Mapping[type, Callable[[_Change, Any], None]] = {
    Append: _append,
    ChangeQueue: _queue,
    Pause: _pause,
    Resume: _resume,
    Stop: _stop,
    Answer: _answer,
    Ready: _ready,
    StepEnded: _step_ended,
    Sent: _sent,
    Settled: _settled,
    Tick: _tick,
    Restarted: _restarted,
    Delivered: lambda change, event: setattr(
        change, "state", replace(change.state, delivered=max(change.state.delivered, event.number))
    ),
    Disk: lambda change, event: setattr(change, "state", replace(change.state, disk=event.problem)),
}
