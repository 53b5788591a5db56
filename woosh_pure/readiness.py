"""Why the chassis would not move now, in words. Pure: a function of what is known."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .enums import RobotMode, RobotState, WorkMode
from .faults import Department, FaultLevel, StatusCode
from .rivals import ROBOT_ITSELF

if TYPE_CHECKING:
    from .values import RobotStatus

__all__ = ["Readiness", "Reason", "assess"]


@dataclass(frozen=True, slots=True)
class Reason:
    """One thing that speaks against moving.

    Attributes:
        key: For programs: "emergency_stop", "manual_mode", "not_in_task_mode", "not_localised",
            "mapping", "no_map", "bumper", "charging_cable", "fault", "busy" (a task of ours is under way),
            "other_client" (somebody else commands it), "unknown".
        text: For people.
        blocking: False when it is only worth knowing (nothing heard yet, a task is running, a warning).
    """

    key: str
    text: str
    blocking: bool = True


@dataclass(frozen=True, slots=True)
class Readiness:
    """Whether the chassis would move, as far as is known.

    Attributes:
        reasons: What speaks against it; empty when nothing is known that does.
    """

    reasons: tuple[Reason, ...] = ()

    @property
    def ready(self) -> bool:
        """True when nothing known blocks."""
        return not any(reason.blocking for reason in self.reasons)

    def __bool__(self) -> bool:
        return self.ready

    def __str__(self) -> str:
        """`sentence()`."""
        return self.sentence()

    def sentence(self) -> str:
        """All reasons in one line."""
        if not self.reasons:
            return "nothing known speaks against moving"
        return "; ".join(reason.text for reason in self.reasons)


def assess(
    status: RobotStatus | None,
    faults: Iterable[StatusCode],
    charging: bool | None = None,
    own_tasks: Collection[int] = (),
    rivals: Iterable[tuple[str, str]] = (),
) -> Readiness:
    """What is known against moving.

    Args:
        status: The last /robot_status; None when none was heard (it is published on change only).
        faults: Active faults.
        charging: What /battery says; None when not heard.
        own_tasks: Ids of tasks that we have started ourselves.
        rivals: Other clients with a running goal: (client, action).
    """
    reasons: list[Reason] = []
    if status is None:
        reasons.append(Reason("unknown", "no /robot_status heard yet (it is sent on change only)", False))
    else:
        reasons += _from_status(status, charging, own_tasks)
    reasons += [_from_fault(fault) for fault in faults]
    reasons += [
        _rival(*rival) for rival in rivals if rival[0] != ROBOT_ITSELF or _task_unknown(status, own_tasks)
    ]
    return Readiness(tuple(reasons))


def _from_status(status: RobotStatus, charging: bool | None, own_tasks: Collection[int]) -> list[Reason]:
    reasons = []
    if status.robot_mode in (RobotMode.MANUAL, RobotMode.MAINTENANCE):
        reasons.append(
            Reason("manual_mode", f"the robot is in {status.robot_mode} mode; turn its key to automatic")
        )
    if status.work_mode is WorkMode.DEPLOYMENT:
        reasons.append(
            Reason("not_in_task_mode", "the robot is in deployment mode; tasks need task mode", False)
        )
    if status.robot_state is RobotState.UNINITIALISED:
        reasons.append(
            Reason("not_localised", "the robot does not know where it is; give it its position", False)
        )
    if status.robot_state is RobotState.FAULT:
        reasons.append(Reason("fault", "the robot reports a fault (robot_state 6); look at its display"))
    if status.robot_state is RobotState.MAPPING:
        reasons.append(Reason("mapping", "the robot is making a map"))
    if not status.task_state.is_final and status.task_state.value > 0:
        reasons.append(_task_under_way(status, own_tasks))
    if charging and status.robot_state is not RobotState.CHARGING:
        reasons.append(Reason("charging_cable", "the battery charges without a task; unplug the cable"))
    return reasons


def _task_unknown(status: RobotStatus | None, own_tasks: Collection[int]) -> bool:
    """Whether nothing else tells what task the robot carries out."""
    return status is None and not own_tasks


def _rival(client: str, action: str) -> Reason:
    whose = f"{client} has a goal of its own"
    if client == ROBOT_ITSELF:
        whose = "the robot has a task of another client, or of its own,"
    return Reason("other_client", f"{whose} under way on {action}", False)


def _task_under_way(status: RobotStatus, own_tasks: Collection[int]) -> Reason:
    if status.task_id in own_tasks:
        return Reason("busy", f"our own task {status.task_id} is {status.task_state}", False)
    text = f"task {status.task_id} of another client (or of the robot itself) is {status.task_state}"
    return Reason("other_client", text, False)


_KEYS = {
    (Department.ELECTRICAL, 2, 1): "emergency_stop",
    (Department.ELECTRICAL, 2, 2): "bumper",
    (Department.SYSTEM, 1, 3): "not_localised",
}


def _from_fault(fault: StatusCode) -> Reason:
    key = _KEYS.get((fault.department, fault.module, fault.submodule), "fault")
    if fault.code == 140201000032:
        key = "no_map"
    # Only severe codes (emergency stop, bumper, broken hardware) block every motion; others may block one
    # kind.
    return Reason(key, str(fault), fault.level is FaultLevel.SEVERE)
