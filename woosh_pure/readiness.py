"""Why the chassis would not move now, in words. Pure: a function of what is known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .enums import RobotMode, RobotState, WorkMode
from .faults import Department, FaultLevel, StatusCode

if TYPE_CHECKING:
    from .values import RobotStatus

__all__ = ["Readiness", "Reason", "assess"]


@dataclass(frozen=True, slots=True)
class Reason:
    """One thing that speaks against moving.

    Attributes:
        key: For programs: "emergency_stop", "manual_mode", "not_in_task_mode", "not_localised",
            "charging_cable", "fault", "busy", "unknown".
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

    def sentence(self) -> str:
        """All reasons in one line."""
        if not self.reasons:
            return "nothing known speaks against moving"
        return "; ".join(reason.text for reason in self.reasons)


def assess(
    status: RobotStatus | None, faults: Iterable[StatusCode], charging: bool | None = None
) -> Readiness:
    """What is known against moving.

    Args:
        status: The last /robot_status; None when none was heard (it is published on change only).
        faults: Active faults.
        charging: What /battery says; None when not heard.
    """
    reasons: list[Reason] = []
    if status is None:
        reasons.append(Reason("unknown", "no /robot_status heard yet (it is sent on change only)", False))
    else:
        reasons += _from_status(status, charging)
    reasons += [_from_fault(fault) for fault in faults]
    return Readiness(tuple(reasons))


def _from_status(status: RobotStatus, charging: bool | None) -> list[Reason]:
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
        reasons.append(Reason("busy", f"task {status.task_id} is {status.task_state}", False))
    if charging and status.robot_state is not RobotState.CHARGING:
        reasons.append(Reason("charging_cable", "the battery charges without a task; unplug the cable"))
    return reasons


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
