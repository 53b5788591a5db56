"""`Chassis.stop()`: zero velocity and cancelling, from any thread, at any time, repeating itself.

It is NO emergency stop: it goes over the network and through the chassis's software. A person must be able to
reach the red button.
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rosproto.errors import RosError

from .drivers import other_drivers
from .enums import TaskCommand, TaskState
from .goal import NOT_CONFIRMED
from .interface import actions
from .outcome import OutcomeKind
from .velocity_topics import VELOCITY_TOPICS

if TYPE_CHECKING:
    import rosproto

    from .core import Core
    from .goal import GoalHandle

__all__ = ["StopReport", "cancel_goals", "stop"]

_REPEATS = 6
_TASK_FIRST = 0.5


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

    def __str__(self) -> str:
        """`sentence()`."""
        return self.sentence()

    def sentence(self) -> str:
        """One sentence for people."""
        state = {
            True: "the robot stands still",
            False: "THE ROBOT STILL MOVES: use its emergency stop button",
            None: "whether the robot stands still is not known: watch it",
        }[self.standing]
        parts = [state]
        if self.cancelled:
            parts.append(f"cancelled {', '.join(self.cancelled)}")
        elif not self.problems:
            parts.append("nothing of ours was running")
        if self.problems:
            parts.append(f"not done: {'; '.join(self.problems)}")
        return "; ".join(parts)


def stop(core: Core, *, everything: bool, timeout: float) -> StopReport:
    """See `Chassis.stop`."""
    if not 0.0 <= timeout < math.inf:
        timeout = 5.0  # whatever was given: a stop is not refused for its arguments
    report = StopReport()
    deadline = time.monotonic() + timeout
    core.running.note_stop()
    for drive in core.running.drives:
        drive.halt("stop() was called")
        report.cancelled.append("the velocity block")
    # Zero and cancelling at the same time: neither waits for the other.
    zeros = threading.Thread(target=_zeros, args=(core, report), name="woosh:stop", daemon=True)
    zeros.start()
    cancel_goals(core, report, min(timeout, 3.0))
    if everything:
        _cancel_foreign(core, report)
    zeros.join(max(0.1, deadline - time.monotonic()))
    try:
        report.standing = core.wait_standing(max(0.2, deadline - time.monotonic()))
    except RosError as error:
        report.problems.append(f"looking whether it stands ({error})")
    return report


def _zeros(core: Core, report: StopReport) -> None:
    """Zeros on both topics, on each as soon as somebody listens there."""
    waiting: dict[str, rosproto.Publisher] = {}
    for topic in VELOCITY_TOPICS.values():
        try:
            waiting[topic] = core.velocity.acquire(topic)
        except RosError as error:
            report.problems.append(f"zero velocity on {topic} ({error})")
    acquired = list(waiting)
    try:
        _send_zeros(core, waiting, report)
    finally:
        for topic in acquired:
            core.velocity.release(topic)


def _send_zeros(core: Core, waiting: dict[str, rosproto.Publisher], report: StopReport) -> None:
    end = time.monotonic() + 1.0
    sent: dict[str, int] = {}
    while waiting and any(sent.get(topic, 0) < _REPEATS for topic in waiting):
        for topic, publisher in list(waiting.items()):
            if publisher.connections and sent.get(topic, 0) < _REPEATS:
                core.velocity.zero(topic)
                sent[topic] = sent.get(topic, 0) + 1
            elif not sent.get(topic) and time.monotonic() > end:
                report.problems.append(f"zero velocity on {topic} (nobody listens there)")
                del waiting[topic]
            elif not publisher.connections and sent.get(topic):
                del waiting[topic]  # it took some, and has gone away
        time.sleep(0.05 if sent else 0.01)


def cancel_goals(core: Core, report: StopReport, timeout: float) -> None:
    """Ask for the end of every goal this client started; all at once, not one after the other."""
    workers = []
    for goal in core.running.goals:
        worker = threading.Thread(
            target=_cancel, args=(goal, report, timeout), name="woosh:cancel", daemon=True
        )
        worker.start()
        workers.append((worker, goal))
    for worker, goal in workers:
        worker.join(timeout + 1.0)
        if worker.is_alive():
            report.problems.append(f"cancelling {goal.goal} (no answer yet)")


def _cancel(goal: GoalHandle[object], report: StopReport, timeout: float) -> None:
    try:
        outcome = goal.cancel(timeout)
        if outcome.kind is OutcomeKind.CANCELLED and outcome.text == NOT_CONFIRMED and not outcome.stopped:
            report.problems.append(f"cancelling {goal.goal} ({NOT_CONFIRMED})")
        else:
            report.cancelled.append(f"{goal.goal} ({outcome.kind.value})")
    except RosError as error:
        report.problems.append(f"cancelling {goal.goal} ({error})")


def _cancel_foreign(core: Core, report: StopReport) -> None:
    # A task ends as cancelled when it is told so first, and as failed when its navigation is taken from it.
    # But nobody waits long for that: the navigation is stopped anyway.
    task = threading.Thread(target=_cancel_task, args=(core, report), name="woosh:cancel", daemon=True)
    task.start()
    task.join(_TASK_FIRST)
    workers = [
        threading.Thread(target=_cancel_action, args=(core, name, report), name="woosh:cancel", daemon=True)
        for name in _servers_that_move(core)
    ]
    for worker in workers:
        worker.start()
    for worker in [*workers, task]:
        worker.join(3.0)
    _tell_of_drivers(core, report)


def _servers_that_move(core: Core) -> list[str]:
    """Action servers that drive the robot: those every chassis has, and the others where they are there."""
    rows = [row for row in actions() if row.moves_base]
    try:
        there = core.node.master.get_system_state(timeout=2.0).publishers
    except RosError:
        there = {}
    return [row.name for row in rows if row.source == "page" or f"{row.name}/status" in there]


def _cancel_action(core: Core, name: str, report: StopReport) -> None:
    try:
        core.action(name).cancel_all()
        report.cancelled.append(f"all goals of {name}")
    except RosError as error:
        report.problems.append(f"cancelling {name} ({error})")


def _tell_of_drivers(core: Core, report: StopReport) -> None:
    """Velocities of another program cannot be cancelled: after our zeros it goes on."""
    try:
        drivers = other_drivers(core.node)
    except RosError as error:
        report.problems.append(f"looking for other programs that drive by velocity ({error})")
        return
    for driver in drivers:
        if not driver.on_robot:
            report.problems.append(f"{driver.sentence()}, which only its end stops: end it")


def _cancel_task(core: Core, report: StopReport) -> None:
    try:
        status = core.feed("status").latest
    except RosError:
        status = None
    under_way = (TaskState.RUNNING, TaskState.PAUSED, TaskState.WAITING_FOR_ACTION)
    if status is not None and status.task_state not in under_way:
        return
    task_id = 0 if status is None else status.task_id
    try:
        reply = core.exec_task(TaskCommand.CANCEL, task_id, timeout=3.0)
        if reply.success:
            report.cancelled.append(f"task {task_id}" if status is not None else "the running task")
    except RosError as error:
        report.problems.append(f"cancelling the task ({error})")
