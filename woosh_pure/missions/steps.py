"""`StepRunner`: carries one step of a mission out over the chassis, in a thread, and reports its end once."""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.codec import from_dict, service_class
from rosproto.errors import ConnectionLost, RosError, RosTimeout, ServiceError
from rosproto.files import save_file
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure import interface
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.enums import Direction, TaskState
from woosh_pure.errors import MotionRefused
from woosh_pure.maps.marks import own_marks
from woosh_pure.missions.machine import Result, Run
from woosh_pure.missions.mission import MOVING
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.motion.task_list import stored_task_list
from woosh_pure.outcome import Outcome, OutcomeKind, end_is_known
from woosh_pure.values.messages import message_type

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.faults import StatusCode

_log = get_logger("woosh_pure.missions.steps")
_SLICE = 0.05
_MOTION_SECONDS, _OTHER_SECONDS = 600.0, 60.0
"""Time limits of steps that give none; waiting has none."""
_READING_SECONDS = 5.0
_BEFORE_SECONDS, _AFTER_SECONDS = 1.0, 0.5
_CODES = {
    *(130101000011, 130101000021, 130101000031, 130101000051),  # no way to the target
    *(130104000042, 130104000092, 130104000102),  # navigation failed
    *(130603000012, 130603000032, 130603000042, 130603000052),  # the same in a narrow passage
    *(130701000012, 130701000032),  # a move by steps failed
}
"""Codes of /status_code by which the robot itself tells why it did not get there."""


class _Cancelled(RosError):
    """The run is over; nobody reads the end of this step."""


class OwnReasons:
    """Whether the robot tells why a motion failed. `note` takes in the feed `status_code` from its start.

    A robot may also call a motion failed that somebody else has stopped or replaced. Only a code of its own,
    such as "no way to the target", tells the two apart.
    """

    def __init__(self) -> None:
        self._at = -math.inf

    def note(self, code: StatusCode) -> None:
        """Take in a code."""
        if code.code in _CODES:
            self._at = time.monotonic()

    def told(self) -> bool:
        """Whether the robot tells just now that it cannot get there; the code comes on another link than the
        end, before or after it.
        """
        end = time.monotonic()
        while self._at < end - _BEFORE_SECONDS and time.monotonic() < end + _AFTER_SECONDS:
            time.sleep(0.01)
        return self._at >= end - _BEFORE_SECONDS


class StepRunner:
    """One step under way.

    Args:
        request: Made when the step was due: a stop of the chassis since then prevents its motion.
        report: Called with the events "sent" and "step_ended" of the machine, in its thread.
        folder: For pictures.

    Attributes:
        ended: Set when nothing of it is under way any more.
    """

    def __init__(
        self, chassis: Chassis, run: Run, request: CallScope, report: Callable[..., object], folder: Path
    ) -> None:
        self.chassis, self.folder, self.report = chassis, folder, report
        assert run.step is not None
        self.token, self._step, self.value = run.token, run.step, run.value
        self.limit = run.step.timeout or (_MOTION_SECONDS if run.step.do in MOVING else _OTHER_SECONDS)
        self._cancelled, self._held = threading.Event(), False
        self._ending, self._reasons = ExitStack(), OwnReasons()
        self.ended = threading.Event()
        name = f"woosh:mission {run.token}"
        threading.Thread(target=self._work, args=(request,), name=name, daemon=True).start()

    def want(self, run: Run | None) -> None:
        """Cancel it unless it is of this run; pause it with that, where the chassis can. Returns at once."""
        if run is None or run.token != self.token:
            self._cancelled.set()
        else:
            self._held = run.paused

    def _work(self, request: CallScope) -> None:
        result, text, value = Result.FAILED, "", None
        try:
            with request, self._ending:
                value = _ACTIONS[self._step.do](self)
                result = Result.DONE
                if isinstance(value, Outcome):
                    result, text = result_of(value, self._reasons.told), "" if value.arrived else str(value)
                    value = None
        except MotionRefused as refusal:  # nothing was sent; a person who has pressed a button ends the run
            by_person = refusal.readiness is not None and refusal.readiness.blocked
            result, text = Result.STOPPED if by_person else Result.FAILED, str(refusal)
        except (ConnectionLost, RosTimeout, ServiceError) as error:  # they are OSErrors, too
            result, text = Result.UNKNOWN if self._step.do in MOVING else Result.FAILED, str(error)
        except (RosError, ValueError, KeyError, ImportError, OSError) as error:
            text = str(error)
        except Exception as error:
            _log.exception("! step %s of a mission failed", self._step.do)
            result, text = Result.UNKNOWN, f"{type(error).__name__}: {error}"
        finally:
            self.ended.set()
            self.report("step_ended", token=self.token, result=result, text=text, value=value)

    def goal(self, begin: Callable[[], GoalHandle[Any]]) -> Outcome:
        """Start a goal and wait for its end. One that cannot be paused is cancelled, and sent again."""
        self._ending.callback(self.chassis.feed("status_code").on(self._reasons.note))
        left = self.limit
        while True:
            handle = begin()
            if handle.task_id and self._step.do != "task_list":
                self.report("sent", token=self.token, task=handle.task_id)
            paused = False
            while not handle.done and not self._cancelled.wait(_SLICE):
                if self._held is not paused and hasattr(handle, "pause"):
                    try:
                        to_hold = self._held
                        getattr(handle, "pause" if to_hold else "resume")()
                        paused = to_hold
                    except RosError as error:
                        _log.warning("! a step was not paused or resumed: %s", error)
                        self._cancelled.wait(0.5)
                elif self._held and self._step.do == "go_to":
                    break
                left -= 0.0 if paused else _SLICE
                if left <= 0.0:
                    paused_by_others = getattr(handle, "state", None) is TaskState.PAUSED
                    outcome = handle.wait(0.0, raises=False)  # which cancels it
                    return replace(outcome, kind=OutcomeKind.CANCELLED) if paused_by_others else outcome
            if handle.done:
                return handle.wait(1.0, raises=False)
            outcome = handle.cancel()
            if self._cancelled.is_set() or not outcome.by_us or not end_is_known(outcome):
                return outcome  # it has arrived, or somebody else has ended it meanwhile
            while self._held and not self._cancelled.wait(_SLICE):
                pass
            if self._cancelled.is_set():
                return outcome

    def until(self, ready: Callable[[], bool], limit: float | None = None, *, raises: bool = True) -> None:
        """Wait until `ready` says so, for the step's timeout if no limit is given. A pause does not count.

        Raises:
            ValueError: It did not in time, unless `raises` is false.
        """
        left = limit if limit is not None else self._step.timeout or math.inf
        while not ready():
            if self._cancelled.wait(min(_SLICE, max(0.0, left))):
                raise _Cancelled("cancelled")
            left -= 0.0 if self._held else _SLICE
            if left <= 0.0:
                if raises:
                    raise ValueError(say("it did not come within {seconds} s", seconds=self._step.timeout))
                return

    def battery(self) -> float:
        """The newest percentage."""
        return self.chassis.battery.wait(_READING_SECONDS, new=False).percent

    def input(self) -> bool:
        """Whether an input is triggered."""
        module, number = self.value("module"), self.value("input")
        lines = self.chassis.feed("inputs").wait(_READING_SECONDS, new=False).IOs
        found = [line for line in lines if (line.module, line.id) == (module, number)]
        if not found:
            raise ValueError(
                say("the chassis has no input {number} of module {module}", number=number, module=module)
            )
        return any(line.status == 1 for line in found)


class InputAnswers:
    """Waits for an input that answers the question of a run: it comes on after the first message since.

    Attributes:
        question: As of the run.
        answer, number: The answer and its input; "" and 0 until there is one.
        off: Ends it.
    """

    def __init__(self, chassis: Chassis, run: Run) -> None:
        self.question, self.answer, self.number = run.question, "", 0
        self._names = {number: name for name, number in run.value("inputs").items()}
        self._module, self._before = run.value("module"), frozenset(self._names)
        self.off = chassis.feed("inputs").on(self._note, connect=False)

    def _note(self, message: Any) -> None:
        lines = [line for line in message.IOs if line.module == self._module and line.id in self._names]
        on = frozenset(line.id for line in lines if line.status == 1)
        new, self._before = on - self._before, on
        if len(new) == 1 and not self.answer:  # two at once are no answer
            (self.number,) = new
            self.answer = self._names[self.number]


def result_of(outcome: Outcome, explained: Callable[[], bool]) -> Result:
    """How a step ends whose goal ends so. What somebody stops may end in any way, as failed, too. So it
    counts as stopped, unless it has arrived, its time limit has passed, or the robot has rejected it or tells
    by a code of its own why it failed (`explained`).
    """
    if outcome.arrived:
        return Result.DONE
    if outcome.kind is OutcomeKind.TIMED_OUT and outcome.stopped is True:
        return Result.FAILED
    if not end_is_known(outcome):
        return Result.UNKNOWN
    failed = outcome.kind is OutcomeKind.REJECTED or (outcome.kind is OutcomeKind.FAILED and explained())
    return Result.FAILED if failed else Result.STOPPED


def _drive(begin: Callable[[StepRunner], GoalHandle[Any]]) -> Callable[[StepRunner], Outcome]:
    return lambda step: step.goal(lambda: begin(step))


def _go_to_mark(step: StepRunner) -> GoalHandle[Any]:
    """To a mark of the chassis's map, or to the pose of a place that only the user's list has."""
    name = step.value("mark")
    place = own_marks().get(name)
    if place is not None and place.pose is not None and not place.on_chassis:
        return step.chassis.go_to(place.pose.x, place.pose.y, place.pose.yaw, timeout=None)
    return step.chassis.go_to_mark(name, timeout=None)


def _go_to(step: StepRunner) -> GoalHandle[Any]:
    x, y, yaw = step.value("x"), step.value("y"), math.radians(step.value("degrees"))
    return step.chassis.go_to(x, y, yaw, timeout=None)


def _charge(step: StepRunner) -> Outcome:
    outcome = step.goal(lambda: step.chassis.charge(step.value("mark"), timeout=None))
    percent = step.value("until_percent")
    if outcome.arrived and percent:
        step.until(lambda: step.battery() >= percent)
    return outcome


def _task_list(step: StepRunner) -> Outcome:
    """Its last task is what the robot's history tells; that of an earlier run does not count."""
    chassis, found = step.chassis, stored_task_list(step.chassis.robot_api, step.value("list"))
    past = [task for task in chassis.robot_api.task_history() if task.task_id % 2**64 == found.tasks[-1]]
    after = past[-1].time if past else -1.0
    step.report("sent", token=step.token, task=found.tasks[-1], after=after)
    return step.goal(lambda: chassis.task_list(found, timeout=None))


def _act(step: StepRunner, name: str, type_name: str, **fields: object) -> GoalHandle[Any]:
    return step.chassis.action(name, from_dict(message_type(type_name), fields), timeout=None)


def _lift(step: StepRunner) -> GoalHandle[Any]:
    way = 1 if step.value("to") == "up" else 2  # UP, DOWN
    return _act(step, "/lift_control", "woosh_msgs/LiftControlGoal", mode=1, executeMode=way)


def _picture(step: StepRunner) -> None:
    from rosproto.numeric import encode_png

    stamp = datetime.now().strftime("%Y%m%d-%H%M%S-%f")
    name = re.sub(r"[^\w.-]", "_", step.value("file") or "picture")
    image = step.chassis.camera.wait(_READING_SECONDS)
    save_file(step.folder / f"{name}-{stamp}.png", encode_png(image.visible()))


def _call(step: StepRunner) -> None:
    name = step.value("service")
    if name.rpartition("/")[2] == "exec_task":
        wrong = "{name} moves the robot; use the steps that do, which know how to stop"
        raise ValueError(say(wrong, name=name))
    service = service_class(step.value("type") or interface.row(name).type)
    with step.chassis.node.service_client(name, service) as client:
        client.call(from_dict(service.Request, step.value("request")), timeout=step.limit)


_ACTIONS: Mapping[str, Callable[[StepRunner], Any]] = {
    "go_to_mark": _drive(_go_to_mark),
    "go_to": _drive(_go_to),
    "park": _drive(lambda step: step.chassis.park(step.value("mark"), timeout=None)),
    "load": _drive(lambda step: step.chassis.carry(step.value("mark"), Direction.LOAD, timeout=None)),
    "unload": _drive(lambda step: step.chassis.carry(step.value("mark"), Direction.UNLOAD, timeout=None)),
    "charge": _charge,
    "task_list": _task_list,
    "move": _drive(lambda step: step.chassis.move(step.value("metres"), speed=step.value("speed"))),
    "rotate": _drive(lambda step: step.chassis.rotate(step.value("degrees"), degrees=True)),
    "dock": _drive(
        lambda step: _act(step, "/woosh_auto_dock", "woosh_msgs/AutoDock2Goal", tag_no=step.value("tag"))
    ),
    "lift": _drive(_lift),
    "wait": lambda step: step.until(lambda: False, step.value("seconds"), raises=False),
    "wait_for_input": lambda step: step.until(lambda: step.input() is step.value("is")),
    "wait_for_battery": lambda step: step.until(lambda: step.battery() >= step.value("percent")),
    "light": lambda step: step.chassis.light(step.value("state"), color=step.value("color") or None),
    "say": lambda step: step.chassis.say(step.value("text")),
    "picture": _picture,
    "call": _call,
    "if": lambda step: step.battery() if step.value("value") == "battery" else step.input(),
}
"""For each kind that is not decided by the machine. A result that is an `Outcome` says how the goal ended."""
