"""`Chassis.stop()`: zero velocity and cancelling, from any thread, at any time, repeating itself.

It is NO emergency stop: it goes over the network and through the chassis's software. A person must be able to
reach the red button.
"""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.numbers import as_float
from rosproto.transport import Deadline
from woosh_pure.stopping.other_clients import OtherPrograms, cancel_others
from woosh_pure.stopping.registrations import Registrations
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.running import cancel_goals
from woosh_pure.velocity.topics import VELOCITY_TOPICS

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.core import Core

__all__ = ["stop", "stop_seconds"]

_REPEATS = 6
_LISTENERS = 1.0  # seconds that subscribers of velocities have at least to connect
_LONGEST = 3600.0  # seconds; the system's waits take no number as large as a float can be
_STEADY = 1.0  # seconds for which it must stand still while another program may drive it


def stop_seconds(given: float) -> float:
    """How long a stop may take; 5 s for nonsense: a stop is not refused for its arguments."""
    try:
        seconds = as_float(given)
    except (TypeError, ValueError):
        return 5.0
    return min(seconds, _LONGEST) if seconds is not None and 0.0 <= seconds < math.inf else 5.0


def stop(core: Core, *, everything: bool, end_drivers: bool, timeout: float) -> StopReport:
    """See `Chassis.stop`."""
    report = StopReport()
    deadline = Deadline(timeout)
    core.running.note_stop()
    for drive in core.running.drives:
        drive.halt("stop() was called")
        report.cancelled.append("the velocity block")
    registrations = Registrations(core.connection)
    # Zeros, cancels and the search for other drivers run at the same time: none waits for another.
    zeros = threading.Thread(
        target=_zeros, args=(core, registrations, report, deadline), name="woosh:stop", daemon=True
    )
    zeros.start()
    programs = (
        OtherPrograms(core.connection, deadline, end=end_drivers) if everything or end_drivers else None
    )
    cancel_goals(core.running.take_goals(), report, min(timeout, 3.0), "stop() was called")
    if everything:
        cancel_others(core, registrations, report, deadline)
    zeros.join(max(_LISTENERS, deadline.remaining() or 0.0) + 0.5)
    if programs is not None:
        programs.wait(report)
        if programs.ended:
            _zeros(core, registrations, report, deadline)  # they may have ended without sending zero
    report.standing = _standing(
        core, registrations, report, deadline, programs is not None and programs.drive_on
    )
    if missing := registrations.sentence():
        report.problems.append(missing)
    return report


def _standing(
    core: Core, registrations: Registrations, report: StopReport, deadline: Deadline, driven: bool
) -> bool | None:
    """Whether it stands still, and stays so where another program may drive it."""
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
