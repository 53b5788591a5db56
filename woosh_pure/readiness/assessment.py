"""Derives the reasons why the chassis would not move, from what is known. Pure.

Its sources are `/robot_status`, `/status_code`, `/battery`, `/IO_input` and the states of the action servers.
The chassis is never probed, because every possible probe has side effects:

- `/exec_task` replies with the state of the robot, but each of its commands runs, pauses, resumes or ends a
  task, and what the chassis does with an unknown command or task id is not documented.
- A goal of zero length on `/cmd_vel_control` or `/move_base` is not harmless either. An action server of this
  kind ends its current goal when a new one comes, so the probe would end a task of the robot itself or of
  another client. It may make the robot leave the charger, and the reply to an empty list of steps is not
  documented.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

from rosproto.codec import DynamicMessage
from rosproto.sentence import say
from woosh_pure.enums import RobotMode, RobotState, WorkMode
from woosh_pure.faults import Department, FaultLevel, StatusCode, decode_status_code
from woosh_pure.reasons import Readiness, Reason, ReasonKey
from woosh_pure.values.state import RobotStatus

_CODE = re.compile(r"(?<!\d)\d{12}(?!\d)")
_STOPPED = (RobotState.FAULT, RobotState.MAPPING)
_SAYS_NOTHING = (None, RobotState.UNDEFINED, RobotState.UNINITIALISED)


@dataclass(frozen=True, slots=True)
class _Refusal:
    at: float
    reason: Reason
    sources: frozenset[tuple[int, int, int, int]]


class Refusals:
    """The newest refusal or failure of a motion, remembered until its cause is shown to be over.

    A cause from before we connected (a pressed emergency stop, a bumper that was hit) may never appear on a
    topic, but the chassis then refuses motions. So the refusal is remembered, and readiness lists it as a
    reason. Safe from any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: _Refusal | None = None

    def note(self, text: str, at: float, state: RobotState | None = None) -> None:
        """Remember that a motion was refused or has failed.

        Args:
            text: Which motion, and the chassis's reason.
            at: When, by the monotonic clock.
            state: The robot's state reported along with it; None if it was not.
        """
        severe = [code for code in _codes(text) if code.level is FaultLevel.SEVERE]
        blocking = bool(severe) or state in _STOPPED
        doubt = not blocking and state in _SAYS_NOTHING
        reason = Reason(ReasonKey.REFUSED, text, blocking, doubt)
        with self._lock:
            self._last = _Refusal(at, reason, frozenset(code.source for code in severe))

    def end(self) -> None:
        """Forget the refusal: the robot has moved since."""
        with self._lock:
            self._last = None

    def end_before(self, moment: float) -> None:
        """Forget a refusal from before this moment, at which the robot reported that it is over."""
        with self._lock:
            if self._last is not None and self._last.at < moment:
                self._last = None

    def doubt(self) -> None:
        """Mark the cause as possibly over: the robot may have been restarted."""
        with self._lock:
            if self._last is not None:
                self._last = replace(self._last, reason=self._last.reason.doubted())

    def receive(self, code: StatusCode) -> None:
        """Take in a status code; one that ends a fault also ends the refusal because of it."""
        if not code.known or code.level is not FaultLevel.NORMAL:
            return
        depth = 4 if code.submodule else 3
        with self._lock:
            last = self._last
            if last is not None and any(s[:depth] == code.source[:depth] for s in last.sources):
                self._last = None

    def reasons(self) -> tuple[Reason, ...]:
        """The remembered refusal as reasons, for a `Readiness`."""
        with self._lock:
            return () if self._last is None else (self._last.reason,)


def _codes(text: str) -> list[StatusCode]:
    return [decode_status_code(int(number)) for number in _CODE.findall(text)]


NOT_HEARD = (
    "no /robot_status heard yet (it is sent on change only), so an earlier emergency stop, fault or "
    "mode is not known"
)
LINK_LOST = "the connection to the publisher of /robot_status has broken since: its value may be out of date"
BEFORE = "{fault}; it was reported before the connection to its publisher broke: it may be over"
STATE_UNDEFINED = "the robot does not report its state"
FAULT_STATE = "the robot reports a fault; look at its display"
KEY_TRIGGERED = (
    "key {number} of the chassis is triggered (/IO_input): it may be the emergency stop, which key is which "
    "is not documented"
)


ROBOT_ITSELF = "/ros_interface"
"""The chassis's own node that carries out tasks, which is a client of the action servers."""


def assess(
    status: RobotStatus | None,
    faults: Iterable[StatusCode],
    charging: bool | None = None,
    own_tasks: Collection[int] = (),
    other_goals: Iterable[tuple[str, str]] = (),
    *,
    faults_before: Iterable[StatusCode] = (),
    keys: Collection[int] = (),
    refusals: Iterable[Reason] = (),
    link_lost: bool = False,
    has_moved: bool = False,
) -> Readiness:
    """Collect the known reasons against moving, and the unknown facts; the cause comes first.

    Args:
        status: The last /robot_status; None if none was received (it is published on change only).
        faults: Active faults.
        charging: By /battery; None if none was received.
        own_tasks: Ids of the tasks that this client started.
        other_goals: Other clients with a running goal: (client, action).
        faults_before: Faults received over links that have broken since; they may be over.
        keys: Numbers of the chassis's keys that /IO_input shows as triggered.
        refusals: Refusals and failures that are not known to be over.
        link_lost: The link of /robot_status has broken since its last message, which then blocks no longer.
        has_moved: One of our motions has arrived, so nothing stopped the robot at that time, and every change
            since then was reported.
    """
    from_faults = [_from_fault(fault) for fault in faults]
    reasons: list[Reason] = []
    if status is not None:
        told_by_status = _from_status(status, charging, own_tasks)
        if any(reason.blocking for reason in from_faults):  # they name the fault
            told_by_status = [reason for reason in told_by_status if reason.key is not ReasonKey.FAULT]
        reasons += [reason.doubted() for reason in told_by_status] if link_lost else told_by_status
    elif not has_moved:
        reasons.append(Reason(ReasonKey.UNKNOWN, NOT_HEARD, False, doubt=True))
    if link_lost:
        reasons.append(Reason(ReasonKey.LINK_LOST, LINK_LOST, False, doubt=True))
    reasons += from_faults
    reasons += [
        replace(_from_fault(fault), text=say(BEFORE, fault=fault)).doubted() for fault in faults_before
    ]
    reasons += [
        _other_goal(*other)
        for other in other_goals
        if other[0] != ROBOT_ITSELF
        or (status is None and not own_tasks)  # else another reason names its task
    ]
    reasons += [Reason(ReasonKey.CHASSIS_KEY, say(KEY_TRIGGERED, number=key), False) for key in keys]
    blocking_keys = {reason.key for reason in reasons if reason.blocking}
    reasons += [reason for reason in refusals if not blocking_keys]  # otherwise the state is more exact
    return Readiness(tuple(sorted(reasons, key=_order)))


def _order(reason: Reason) -> tuple[bool, bool, bool]:
    """Sort key: a pressed button first (it explains the rest), then blocking reasons, then unknown facts."""
    pressed = reason.key in (ReasonKey.EMERGENCY_STOP, ReasonKey.BUMPER)
    return not pressed, not reason.blocking, not reason.doubt


def lacks_code(readiness: Readiness) -> bool:
    """Whether a fault is known by the robot's state only, so that no status code says which one."""
    return _OF_STATE[RobotState.FAULT] in readiness.reasons


def status_shows_fitness(status: RobotStatus) -> bool:
    """Whether the state shows that nothing stops the robot, so that earlier causes are over."""
    automatic = status.robot_mode not in (RobotMode.MANUAL, RobotMode.MAINTENANCE)
    return automatic and status.robot_state in _FIT


_FIT = (RobotState.IDLE, RobotState.PARKING, RobotState.IN_TASK, RobotState.CHARGING)


def triggered_keys(inputs: DynamicMessage) -> tuple[int, ...]:
    """Numbers of the chassis's own keys that a woosh_msgs/IOs shows as triggered; () without one."""
    lines = () if inputs is None else inputs.IOs
    return tuple(int(line.id) for line in lines if line.module == _KEYS_MODULE and line.status == _TRIGGERED)


_KEYS_MODULE, _TRIGGERED = 1, 1  # woosh_msgs/IO: module 0x01 chassis keys, status 1 triggered


_LOST = "the robot does not know where it is; give it its position"
_OF_STATE = {
    # States that say nothing about faults and buttons are doubts.
    RobotState.UNINITIALISED: Reason(ReasonKey.NOT_LOCALISED, _LOST, False, doubt=True),
    RobotState.UNDEFINED: Reason(ReasonKey.UNKNOWN, STATE_UNDEFINED, False, doubt=True),
    RobotState.FAULT: Reason(ReasonKey.FAULT, FAULT_STATE),
    RobotState.MAPPING: Reason(ReasonKey.MAPPING, "the robot is making a map"),
}


def _from_status(status: RobotStatus, charging: bool | None, own_tasks: Collection[int]) -> list[Reason]:
    reasons = []
    if status.robot_mode in (RobotMode.MANUAL, RobotMode.MAINTENANCE):
        reasons.append(
            Reason(
                ReasonKey.MANUAL_MODE,
                say("the robot is in {mode} mode; turn its key to automatic", mode=status.robot_mode),
            )
        )
    if status.work_mode is WorkMode.DEPLOYMENT:
        reasons.append(
            Reason(ReasonKey.NOT_IN_TASK_MODE, "the robot is in deployment mode; tasks need task mode", False)
        )
    if status.robot_state in _OF_STATE:
        reasons.append(_OF_STATE[status.robot_state])
    if not status.task_state.is_final and status.task_state.value > 0:
        reasons.append(_task_under_way(status, own_tasks))
    if charging and status.robot_state is not RobotState.CHARGING:
        reasons.append(
            Reason(ReasonKey.CHARGING_CABLE, "the battery charges without a task; unplug the cable")
        )
    return reasons


def _other_goal(client: str, action: str) -> Reason:
    if client == ROBOT_ITSELF:
        text = say(
            "the robot has a task of another client, or of its own, under way on {action}", action=action
        )
    else:
        text = say("{client} has a goal of its own under way on {action}", client=client, action=action)
    return Reason(ReasonKey.OTHER_CLIENT, text, False)


def _task_under_way(status: RobotStatus, own_tasks: Collection[int]) -> Reason:
    if status.task_id in own_tasks:
        return Reason(
            ReasonKey.BUSY,
            say("our own task {id} is {state}", id=status.task_id, state=status.task_state),
            False,
        )
    text = say(
        "task {id} of another client (or of the robot itself) is {state}",
        id=status.task_id,
        state=status.task_state,
    )
    return Reason(ReasonKey.OTHER_CLIENT, text, False)


_KEYS = {
    (Department.ELECTRICAL, 2, 1): ReasonKey.EMERGENCY_STOP,
    (Department.ELECTRICAL, 2, 2): ReasonKey.BUMPER,
    (Department.SYSTEM, 1, 3): ReasonKey.NOT_LOCALISED,
}


def _from_fault(fault: StatusCode) -> Reason:
    key = _KEYS.get((fault.department, fault.module, fault.submodule), ReasonKey.FAULT)
    if fault.code == 140201000032:
        key = ReasonKey.NO_MAP
    # Only severe codes (emergency stop, bumper, broken hardware) block every motion; others may block one
    # kind.
    return Reason(key, str(fault), fault.level is FaultLevel.SEVERE)
