"""A slow, obvious model of the machine of missions, and random missions and events for both.

The model keeps plain dicts, and has no table: it asks after each event what should follow.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from hypothesis import strategies as st

from woosh_pure.missions import machine
from woosh_pure.missions.machine import Result
from woosh_pure.missions.mission import Mission, mission_of

OVER = ("done", "failed", "stopped")
MOVING = ("go_to_mark", "charge", "task_list")
HARMLESS = ("wait", "wait_for_input", "wait_for_battery", "if", "ask")


class No(Exception):
    """The model refuses an event."""


class Event(SimpleNamespace):
    """An event of the machine: its name, and its values as attributes."""

    def __init__(self, name: str, **values: Any) -> None:
        super().__init__(name=name, **values)
        self.values = values


class Model:
    """One robot's missions. `carried` are the steps that were begun, `answer_to` what each event makes of it."""

    def __init__(self) -> None:
        self.queue: list[dict[str, Any]] = []
        self.paused, self.disk, self.next_id = False, False, 1
        self.run: dict[str, Any] | None = None
        self.begun: list[str] = []
        self.token = 0

    # -- what can be seen of it

    def seen(self) -> tuple[Any, ...]:
        run = self.run
        one = (
            None
            if run is None
            else (run["id"], run["phase"], run["at"], run["failed"], run["paused"], run["charging"])
        )
        return one, self.paused, [entry["id"] for entry in self.queue]

    # -- helpers

    def active(self) -> bool:
        return self.run is not None and self.run["phase"] not in OVER

    def steps(self) -> list[dict[str, Any]]:
        assert self.run is not None
        return self.run["mission"].get("on_abort" if self.run["failed"] else "step", [])

    def step(self) -> dict[str, Any] | None:
        assert self.run is not None
        if self.run["charging"]:
            return {"do": "charge"}
        found = self.steps()
        return found[self.run["at"]] if self.run["at"] < len(found) else None

    def new_run(self, entry: dict[str, Any]) -> None:
        self.run = {
            **entry, "phase": "waiting", "at": 0, "failed": False, "paused": False, "charging": False, "begun": False,
            "tries": 0, "counts": {}, "mark": "", "answer": "", "due": None, "unknown": False,
        }  # fmt: skip

    def fail(self) -> None:
        run = self.run
        assert run is not None
        if run["mission"].get("on_abort") and not run["failed"]:
            run.update(failed=True, at=0, tries=0, phase="waiting", begun=False, due=None)
        else:
            self.over("failed")

    def over(self, phase: str) -> None:
        assert self.run is not None
        self.paused = self.paused or phase != "done"
        self.run.update(phase=phase, begun=False, due=None, paused=False)

    def lead(self, target: str) -> None:
        run = self.run
        assert run is not None
        run.update(phase="waiting", tries=0, begun=False, due=None, unknown=False)
        if target == "next":
            run["at"] += 1
        elif target == "end":
            self.over("done")
        elif target == "stop":
            self.fail()
        else:
            run["at"] = [step.get("name") for step in run["mission"]["step"]].index(target)

    def decide(self, step: dict[str, Any], value: Any) -> None:
        if step["value"] == "battery":
            met = value < step["below"] if "below" in step else value > step["above"]
        elif step["value"] == "input":
            met = step["is"] == ("on" if value else "off")
        else:
            met = step["is"] == value
        self.lead(step.get("then", "next") if met else step.get("else", "next"))

    def begin(self, do: str) -> None:
        assert self.run is not None
        self.token += 1
        self.run.update(phase="running", begun=True, due=None, token=self.token)
        self.begun.append(do)

    def follow(self) -> None:
        for _ in range(machine._MAX_TURNS):
            if self.disk:
                return
            if not self.active():
                if self.paused or not self.queue:
                    return
                self.new_run(self.queue.pop(0))
                continue
            run = self.run
            assert run is not None
            if run["phase"] != "waiting" or run["paused"]:
                return
            step = self.step()
            if step is None:
                self.over("failed" if run["failed"] else "done")
            elif step["do"] == "ask":
                run.update(phase="asking", due=self.now + step["timeout"] if step.get("timeout") else None)
                return
            elif step["do"] == "if" and step["value"] in ("mark", "answer"):
                self.decide(step, run[step["value"]])
            elif step["do"] == "go_on":
                self.lead(step["with"])
            elif step["do"] == "repeat":
                count = run["counts"].get(run["at"], 0) + 1
                again = step.get("times", 0) == 0 or count < step["times"]
                run["counts"][run["at"]] = count if again else 0
                self.lead(step["from"] if again else "next")
            elif step["do"] in MOVING:
                return
            else:
                self.begin(step["do"])
                return
        if self.active():
            self.fail()

    def ended(self, ok: bool, value: Any = None) -> None:
        run, step = self.run, self.step()
        assert run is not None
        assert step is not None
        if run["charging"]:
            run.update(charging=False, phase="waiting", begun=False, due=None, unknown=False)
            if not ok:
                self.fail()
        elif ok or run["failed"]:
            if ok and "mark" in step:
                run["mark"] = step["mark"]
            if step["do"] == "if":
                self.decide(step, value)
            else:
                self.lead("next")
        elif run["tries"] < step.get("retries", 0):
            run.update(
                tries=run["tries"] + 1,
                phase="retrying",
                begun=False,
                due=self.now + step.get("retry_pause", 5.0),
            )
        elif step.get("on_failure", "stop") == "stop":
            self.fail()
        else:
            self.lead(step["on_failure"])

    # -- events

    def apply(self, event: Any, now: float) -> None:
        self.now, self.begun = now, []
        getattr(self, f"on_{event.name}")(event)
        self.follow()

    def on_append(self, event: Any) -> None:
        if (event.start and self.active()) or self.disk or len(self.queue) >= machine.MAX_QUEUE:
            raise No
        entry = {"id": str(self.next_id), "mission": event.mission.data()}
        self.next_id += 1
        if event.start:
            self.new_run(entry)
        else:
            self.queue.append(entry)

    def on_change_queue(self, event: Any) -> None:
        if not event.id:
            self.queue = []
            return
        found = [entry for entry in self.queue if entry["id"] == event.id]
        if not found:
            raise No
        self.queue.remove(found[0])
        if event.place is not None:
            self.queue.insert(event.place, found[0])

    def on_pause(self, event: Any) -> None:
        self.paused = True
        if self.active() and self.run is not None:
            self.run["paused"] = True

    def on_resume(self, event: Any) -> None:
        self.paused = False
        if not self.active() or self.run is None:
            return
        self.run["paused"] = False
        if self.run["phase"] == "interrupted":
            self.run["phase"] = "asking" if self.run["begun"] else "waiting"
            self.run["unknown"] = self.run["begun"]

    def on_stop(self, event: Any) -> None:
        self.paused = True
        if self.active() and self.run is not None:
            self.over("stopped")

    def on_answer(self, event: Any) -> None:
        run = self.run
        if run is None or run["phase"] != "asking":
            raise No
        step = self.step()
        assert step is not None
        answers = machine.UNKNOWN_ANSWERS if run["unknown"] else tuple(step["answers"])
        if event.answer not in answers:
            raise No
        if not run["unknown"]:
            run["answer"] = event.answer
            self.lead(step["answers"][event.answer])
            return
        run["unknown"] = False
        if event.answer == "stop":
            self.on_stop(event)
        elif event.answer == "again":
            run.update(phase="waiting", begun=False)
        elif step["do"] == "if":
            self.lead(step.get("else", "next"))  # nothing was read
        else:
            self.ended(True)

    def on_ready(self, event: Any) -> None:
        run = self.run
        if run is None or run["phase"] != "waiting" or run["paused"] or self.disk or event.reason:
            return
        step = self.step()
        if step is None or step["do"] not in MOVING:
            return
        low = run["mission"].get("guards", {}).get("battery_below", 0)
        if event.battery is not None and event.battery < low and not run["failed"]:
            run["charging"] = True
            step = {"do": "charge"}
        self.begin(step["do"])

    def on_step_ended(self, event: Any) -> None:
        run = self.run
        if run is None or run["phase"] != "running" or run["token"] != event.token:
            return
        if event.result is Result.STOPPED:
            self.paused = True
            self.over("stopped")
        elif event.result is Result.UNKNOWN:
            run.update(phase="asking", unknown=True, paused=False)
        else:
            self.ended(event.result is Result.DONE, event.value)

    def on_settled(self, event: Any) -> None:
        run = self.run
        if run is not None and run["phase"] == "interrupted" and run["begun"] and run["token"] == event.token:
            run["paused"] = True
            self.ended(event.done)

    def on_tick(self, event: Any) -> None:
        run = self.run
        if run is None or run["due"] is None or run["paused"] or self.now < run["due"]:
            return
        if run["phase"] == "retrying":
            run.update(phase="waiting", due=None)
        elif run["phase"] == "asking":
            step = self.step()
            assert step is not None
            run["answer"] = step["default"]
            self.lead(step["answers"][step["default"]])

    def on_restarted(self, event: Any) -> None:
        self.paused = self.paused or bool(self.queue) or not event.carries
        run = self.run
        if self.active() and run is not None and run["phase"] != "interrupted":
            step = self.step()
            harmless = step is None or step["do"] in HARMLESS
            run.update(
                phase="interrupted",
                begun=run["begun"] and not harmless,
                paused=False,
                due=None,
                unknown=False,
            )
            self.paused = True

    def on_disk(self, event: Any) -> None:
        self.disk = bool(event.problem)


# -- random missions and events

_NAMES = ("a", "b", "c")
_targets = st.sampled_from(("next", "end", "stop", *_NAMES))
_common = st.fixed_dictionaries(
    {}, optional={"retries": st.integers(0, 2), "retry_pause": st.just(1.0), "on_failure": _targets}
)
_step = st.one_of(
    st.builds(lambda common: {"do": "go_to_mark", "mark": "A1", **common}, _common),
    st.builds(lambda common: {"do": "charge", "mark": "C1", **common}, _common),
    st.builds(lambda common: {"do": "task_list", "list": "Round", **common}, _common),
    st.builds(lambda common: {"do": "light", "state": "red", **common}, _common),
    st.builds(lambda common: {"do": "wait", "seconds": 1, **common}, _common),
    st.builds(
        lambda yes, no, timed: {"do": "ask", "text": "?", "answers": {"yes": yes, "no": no}, **timed},
        _targets, _targets, st.sampled_from(({}, {"timeout": 2, "default": "no"}, {"inputs": {"yes": 1}})),
    ),
    st.builds(lambda name, times: {"do": "repeat", "from": name, "times": times}, st.sampled_from(_NAMES), st.integers(0, 3)),
    st.builds(lambda one, other: {"do": "if", "value": "answer", "is": "yes", "then": one, "else": other}, _targets, _targets),
    st.builds(lambda one, other: {"do": "if", "value": "mark", "is": "A1", "then": one, "else": other}, _targets, _targets),
    st.builds(lambda one, other: {"do": "if", "value": "battery", "below": 40, "then": one, "else": other}, _targets, _targets),
    st.builds(lambda one: {"do": "if", "value": "input", "input": 1, "is": "on", "then": one}, _targets),
    st.builds(lambda target: {"do": "go_on", "with": target}, _targets),
)  # fmt: skip


@st.composite
def missions(draw: st.DrawFn) -> Mission:
    """A mission of three to six steps, of which three have names."""
    steps = draw(st.lists(_step, min_size=3, max_size=6))
    data: dict[str, Any] = {"mission": 1, "name": "random"}
    data["step"] = [
        {**step, "name": name} for step, name in zip(steps, (*_NAMES, "", "", ""), strict=False) if name
    ] + steps[3:]
    if draw(st.booleans()):
        data["guards"] = {"battery_below": 20, "charger": "C1"}
    if draw(st.booleans()):
        data["on_abort"] = [{"do": "light", "state": "red"}, {"do": "go_to_mark", "mark": "P1"}]
    return mission_of(data)


def events(draw: st.DrawFn, state: machine.State, pool: list[Mission]) -> tuple[Event, float]:
    """The next event, more often one that matters, and the seconds that pass before."""
    run = state.run
    token = 0 if run is None else run.token
    likely: list[Any] = []
    if run is not None and run.phase is machine.Phase.RUNNING:
        likely = ["end"] * 12
    elif run is not None and run.phase is machine.Phase.ASKING:
        likely = ["answer"] * 10
    elif run is not None and run.phase is machine.Phase.INTERRUPTED:
        likely = ["resume"] * 8
    elif state.needs_ready:
        likely = ["ready"] * 12
    elif run is None or run.phase.over:
        likely = ["start"] * 8
    others = [
        "start",
        "append",
        "queue",
        "pause",
        "resume",
        "stop",
        "answer",
        "ready",
        "end",
        "settle",
        "tick",
        "restart",
        "disk",
    ]
    what = draw(st.sampled_from([*likely, *others, "tick", "tick", "resume", "well"]))
    passed = draw(st.sampled_from((0.0, 0.5, 3.0)))
    if what in ("start", "append"):
        return Event(
            "append", mission=draw(st.sampled_from(pool)), parameters={}, by="x", start=what == "start"
        ), passed
    if what == "queue":
        place = draw(st.none() | st.integers(0, 3))
        return Event(
            "change_queue",
            by="x",
            id=draw(st.sampled_from(("", *(e.id for e in state.queue), "77"))),
            place=place,
        ), passed
    if what == "answer":
        return Event(
            "answer", answer=draw(st.sampled_from(("yes", "no", "done", "again", "stop", "?"))), by="x"
        ), passed
    if what == "ready":
        return Event(
            "ready",
            reason=draw(st.sampled_from(("", "", "", "estop"))),
            battery=draw(st.sampled_from((None, 10.0, 90.0))),
        ), passed
    if what == "end":
        result = draw(
            st.sampled_from((Result.DONE,) * 6 + (Result.FAILED,) * 3 + (Result.STOPPED, Result.UNKNOWN))
        )
        reads = run is not None and run.step is not None and run.step.do == "if"
        value = None
        if reads and run is not None and run.step is not None:
            battery = run.step.value("value") == "battery"
            value = draw(st.sampled_from((10.0, 90.0))) if battery else draw(st.booleans())
        return Event(
            "step_ended",
            token=draw(st.sampled_from((token, token, token, token - 1))),
            result=result,
            text="text",
            value=value,
        ), passed
    simple = {
        "pause": Event("pause", by="x"), "resume": Event("resume", by="x"), "stop": Event("stop", by="x"),
        "settle": Event("settled", token=token, done=draw(st.booleans())), "tick": Event("tick"),
        "restart": Event("restarted", carries=draw(st.booleans())), "disk": Event("disk", problem="full"),
        "well": Event("disk", problem=""),
    }  # fmt: skip
    return simple[what], passed
