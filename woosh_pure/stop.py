"""`Chassis.stop()`: zero velocity and cancelling, from any thread, at any time, repeating itself.

It is NO emergency stop: it goes over the network and through the chassis's software. A person must be able to
reach the red button.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import rosproto
from rosproto.errors import RosError

from .core import VELOCITY_TOPICS
from .enums import TaskCommand, TaskState

if TYPE_CHECKING:
    from .core import Core
    from .goal import GoalHandle

__all__ = ["StopReport", "cancel_goals", "stop"]

_REPEATS = 6
_STOPPABLE = ("/move_base", "/cmd_vel_control")


@dataclass(slots=True)
class StopReport:
    """What `stop` did.

    Attributes:
        standing: True when the measured velocity is zero, False when the robot still moves, None when not
            known.
        cancelled: What was cancelled, in words.
        problems: What could not be done, in words.
    """

    standing: bool | None = None
    cancelled: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def sentence(self) -> str:
        """One sentence for people."""
        state = {
            True: "the robot stands still",
            False: "THE ROBOT STILL MOVES: use its emergency stop button",
            None: "whether the robot stands still is not known: watch it",
        }[self.standing]
        done = f"cancelled {', '.join(self.cancelled)}" if self.cancelled else "nothing of ours was running"
        bad = f"; not done: {'; '.join(self.problems)}" if self.problems else ""
        return f"{state}; {done}{bad}"


def stop(core: Core, *, everything: bool, timeout: float) -> StopReport:
    """See `Chassis.stop`."""
    report = StopReport()
    deadline = time.monotonic() + timeout
    for drive in core.drives:
        drive.halt("stop() was called")
        report.cancelled.append("the velocity block")
    # Zero and cancelling at the same time: neither waits for the other.
    zeros = threading.Thread(target=_zeros, args=(core, report), name="woosh:stop", daemon=True)
    zeros.start()
    cancel_goals(core, report, min(timeout, 3.0))
    if everything:
        _cancel_foreign(core, report)
    zeros.join(max(0.1, deadline - time.monotonic()))
    report.standing = core.wait_standing(max(0.2, deadline - time.monotonic()))
    return report


def _zeros(core: Core, report: StopReport) -> None:
    topics = []
    for topic in VELOCITY_TOPICS.values():
        try:
            publisher = core.velocity_publisher(topic)
            publisher.wait_for_connection(timeout=1.0)
            topics.append(topic)
        except RosError as error:
            report.problems.append(f"zero velocity on {topic} ({error})")
    for _ in range(_REPEATS):
        for topic in topics:
            core.zero(topic)
        time.sleep(0.05)


def cancel_goals(core: Core, report: StopReport, timeout: float) -> None:
    """Ask for the end of every goal this client started; all at once, not one after the other."""
    workers = []
    for goal in core.goals:
        worker = threading.Thread(
            target=_cancel, args=(goal, report, timeout), name="woosh:cancel", daemon=True
        )
        worker.start()
        workers.append(worker)
    for worker in workers:
        worker.join(timeout + 1.0)


def _cancel(goal: GoalHandle[object], report: StopReport, timeout: float) -> None:
    try:
        outcome = goal.cancel(timeout)
        report.cancelled.append(f"{goal.goal} ({outcome.kind.value})")
    except RosError as error:
        report.problems.append(f"cancelling {goal.goal} ({error})")


def _cancel_foreign(core: Core, report: StopReport) -> None:
    for name in _STOPPABLE:
        try:
            core.action(name).cancel_all()
            report.cancelled.append(f"all goals of {name}")
        except RosError as error:
            report.problems.append(f"cancelling {name} ({error})")
    status = core.feed("status").latest
    under_way = (TaskState.RUNNING, TaskState.PAUSED, TaskState.WAITING_FOR_ACTION)
    if status is not None and status.task_state not in under_way:
        return
    task_id = 0 if status is None else status.task_id
    try:
        reply = core.exec_task(TaskCommand.CANCEL, task_id, timeout=3.0)
        if reply.success:
            report.cancelled.append(f"task {task_id}" if status is not None else "the running task")
    except rosproto.RosError as error:
        report.problems.append(f"cancelling the task ({error})")
