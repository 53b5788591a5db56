"""`Chassis.stop()`: zero velocity and cancelling, from any thread, at any time, repeating itself.

It is NO emergency stop: it goes over the network and through the chassis's software. A person must be able to
reach the red button.
"""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.numbers import as_float
from rosproto.text import printable
from rosproto.transport import Deadline
from woosh_pure.motion.goal import NOT_CONFIRMED
from woosh_pure.outcome import OutcomeKind
from woosh_pure.stopping.keeper import Job, begin
from woosh_pure.stopping.others import OtherPrograms, cancel_others
from woosh_pure.stopping.registrations import Registrations
from woosh_pure.velocity.topics import VELOCITY_TOPICS

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.core import Core
    from woosh_pure.motion.goal import GoalHandle
    from woosh_pure.stopping.running import Running

__all__ = ["StopReport", "cancel_goals", "stop", "stop_seconds"]

_REPEATS = 6
_LISTENERS = 1.0  # seconds at least for those to connect who listen for velocities
_STEADY = 1.0  # seconds for which it must stand beside another program that may drive it


@dataclass(slots=True)
class StopReport:
    """What `stop` did.

    Attributes:
        standing: True when the measured velocity is zero, False when the robot still moves, None when not
            known.
        cancelled: What was cancelled, in words.
        problems: What could not be done, in words.
        looked: Whether it was looked for what others have started, too.
    """

    standing: bool | None = None
    cancelled: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    looked: bool = False

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
            parts.append("nothing was running" if self.looked else "nothing of ours was running")
        if self.problems:
            parts.append(f"not done: {'; '.join(self.problems)}")
        return printable("; ".join(parts))


def stop_seconds(given: float) -> float:
    """How long a stop may take. Whatever was given: a stop is not refused for its arguments."""
    try:
        seconds = as_float(given)
    except (TypeError, ValueError):
        return 5.0
    return seconds if seconds is not None and 0.0 <= seconds < math.inf else 5.0


def stop(core: Core, *, everything: bool, end_drivers: bool, timeout: float) -> StopReport:
    """See `Chassis.stop`."""
    report = StopReport()
    deadline = Deadline(timeout)
    core.running.note_stop()
    for drive in core.running.drives:
        drive.halt("stop() was called")
        report.cancelled.append("the velocity block")
    registrations = Registrations(core.connection)
    # Zero, cancelling and looking for others at the same time: none waits for another.
    zeros = threading.Thread(
        target=_zeros, args=(core, registrations, report, deadline), name="woosh:stop", daemon=True
    )
    zeros.start()
    programs = (
        OtherPrograms(core.connection, deadline, end=end_drivers) if everything or end_drivers else None
    )
    cancel_goals(core.running, report, min(timeout, 3.0), "stop() was called")
    if everything:
        cancel_others(core, registrations, report, deadline)
    zeros.join(max(_LISTENERS, deadline.remaining() or 0.0) + 0.5)
    if programs is not None:
        programs.wait(report)
        if programs.ended:
            _zeros(core, registrations, report, deadline)  # they may have ended without one
    report.standing = _standing(
        core, registrations, report, deadline, programs is not None and programs.drive_on
    )
    if missing := registrations.sentence():
        report.problems.append(missing)
    return report


def _standing(
    core: Core, registrations: Registrations, report: StopReport, deadline: Deadline, driven: bool
) -> bool | None:
    """Whether it stands; where another program drives on, whether it goes on standing."""
    try:
        feed = core.feeds.get("velocity").open()
        if not feed.publishers and registrations.lacks_publisher(feed.topic):
            registrations.miss(feed.topic)
            return None
        standing = core.feeds.wait_standing(max(0.2, deadline.remaining() or 0.0))
        steady = Deadline(_STEADY)
        while standing and driven and (left := steady.remaining()):
            standing = feed.wait(left + 1.0).is_standing()
        return standing
    except RosError as error:
        report.problems.append(f"looking whether it stands ({error})")
        return None


def _zeros(core: Core, registrations: Registrations, report: StopReport, deadline: Deadline) -> None:
    """Zeros on both topics, on each as soon as somebody listens there."""
    waiting: dict[str, rosproto.Publisher] = {}
    failed: dict[str, list[str]] = {}  # the same words for both topics are said once
    for topic in VELOCITY_TOPICS.values():
        try:
            waiting[topic] = core.velocity.acquire(topic)
        except RosError as error:
            failed.setdefault(str(error), []).append(topic)
    for why, topics in failed.items():
        report.problems.append(f"zero velocity on {' and '.join(topics)} ({why})")
    acquired = list(waiting)
    try:
        _send_zeros(core, registrations, waiting, report, deadline)
    finally:
        for topic in acquired:
            core.velocity.release(topic)


def _send_zeros(
    core: Core,
    registrations: Registrations,
    waiting: dict[str, rosproto.Publisher],
    report: StopReport,
    deadline: Deadline,
) -> None:
    listeners = Deadline(max(_LISTENERS, deadline.remaining() or 0.0))
    sent: dict[str, int] = {}
    while waiting and any(sent.get(topic, 0) < _REPEATS for topic in waiting):
        for topic, publisher in list(waiting.items()):
            if publisher.connections and sent.get(topic, 0) < _REPEATS:
                core.velocity.zero(topic)
                sent[topic] = sent.get(topic, 0) + 1
            elif publisher.connections:
                continue
            elif sent.get(topic):
                del waiting[topic]  # it took some, and has gone away
            elif registrations.lacks_subscriber(topic):
                registrations.miss(topic)
                del waiting[topic]
            elif listeners.expired:
                report.problems.append(f"zero velocity on {topic} (nobody has connected to it)")
                del waiting[topic]
        time.sleep(0.05 if sent else 0.01)


def cancel_goals(running: Running, report: StopReport, timeout: float, why: str) -> None:
    """Ask for the end of every goal this client started; all at once, not one after the other.

    Args:
        running: What was started.
        report: Takes what was done, and what was not.
        timeout: Seconds for the chassis to confirm.
        why: In words, for the outcomes.
    """
    jobs = []
    for goal in running.take_goals():
        job = Job(partial(_cancel, goal, report, timeout, why), timeout + 1.0)
        begin(job, "woosh:cancel")
        jobs.append((job, goal))
    for job, goal in jobs:
        job.join()
        if not job.over:
            report.problems.append(f"cancelling {goal.description} (no answer yet)")


def _cancel(goal: GoalHandle[object], report: StopReport, timeout: float, why: str) -> None:
    try:
        outcome = goal._cancel(timeout, why)
        if outcome.kind is OutcomeKind.CANCELLED and outcome.text == NOT_CONFIRMED and not outcome.stopped:
            report.problems.append(f"cancelling {goal.description} ({NOT_CONFIRMED})")
        else:
            report.cancelled.append(f"{goal.description} ({outcome.kind.value})")
    except RosError as error:
        report.problems.append(f"cancelling {goal.description} ({error})")
