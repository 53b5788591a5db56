"""`Chassis.stop()`: the whole sequence of a stop. `immediate_stop` writes its first messages.

It is NO emergency stop: it goes over the network and through the chassis's software. A person must be able to
reach the red button.
"""

from __future__ import annotations

import math
import time
from functools import partial
from typing import TYPE_CHECKING

import rosproto
from rosproto.coercion import as_float
from rosproto.errors import RosError, RosTimeout
from rosproto.sentence import say
from rosproto.transport import Deadline
from rosproto.watchdog import ROUNDS
from woosh_pure.connection.velocity_topics import VELOCITY_TOPICS
from woosh_pure.stopping.active_motions import cancel_goals
from woosh_pure.stopping.immediate_stop import StopRequest
from woosh_pure.stopping.other_clients import OtherPrograms, Registrations, StopRun, cancel_others
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.stop_executor import Job, begin

if TYPE_CHECKING:
    from woosh_pure.components import Components

_WRITTEN = 0.5  # seconds for the first round, which takes a millisecond
_SHORT, _LONG = 4.0, 20.0  # seconds on top of the time limit: the steps have bounds of their own
_LISTENERS = 1.0  # seconds that subscribers of velocities have at least to connect
_MAX_TIMEOUT_SECONDS = 3600.0  # seconds; the system's waits take no number as large as a float can be
_LOOK = 0.5  # seconds at least, to see whether it stands
_STEADY = 1.0  # seconds for which it must stand still while another program may drive it


def stop_seconds(given: float) -> float:
    """Return the time limit of a stop; 5 s for an invalid one: a stop is never refused for its arguments."""
    try:
        seconds = as_float(given)
    except (TypeError, ValueError):
        return 5.0
    return min(seconds, _MAX_TIMEOUT_SECONDS) if seconds is not None and 0.0 <= seconds < math.inf else 5.0


def stop(components: Components, *, everything: bool, end_drivers: bool, timeout: float) -> StopReport:
    """See `Chassis.stop`. `immediate_stop` writes the first zeros and cancels; the other steps are here."""
    drives = components.motions.drives
    ending = components.motions.note_stop()
    report = StopReport(cancelled=["the velocity block"] * len(drives))
    seconds = timeout + (_LONG if everything or end_drivers else _SHORT)
    try:
        components.motions.executor.do(
            lambda: _stop(
                components, ending, report, everything=everything, end_drivers=end_drivers, timeout=timeout
            ),
            seconds,
        )
    except RosTimeout:
        # A frame that a signal handler has interrupted holds a lock, or the network is slow.
        report.problems.append(
            say("looking after it (not done within {seconds:g} s, it goes on)", seconds=seconds)
        )
    except RecursionError:
        raise  # the caller answers without a call
    except (RosError, OSError, RuntimeError) as error:
        report.problems.append(say("all of it ({error})", error=error))
    return report


def _stop(
    components: Components,
    ending: StopRequest,
    report: StopReport,
    *,
    everything: bool,
    end_drivers: bool,
    timeout: float,
) -> None:
    deadline = Deadline(timeout)
    ending.written.wait(_WRITTEN)
    report.problems += ending.problems
    registrations = Registrations(components.connection, deadline)
    run = StopRun(components, registrations, report, deadline)
    # Zeros, cancels and the search for other drivers run at the same time: none waits for another.
    zeros = Job(partial(_zeros, run), timeout + _LISTENERS)
    begin(zeros, "woosh:stop")
    programs = (
        OtherPrograms(components.connection, deadline, end=end_drivers) if everything or end_drivers else None
    )
    cancel_goals(components.motions.take_goals(), report, min(timeout, 3.0), ending.why)
    if everything:
        cancel_others(run)
    zeros.join(max(_LISTENERS, deadline.remaining() or 0.0) + 0.5)
    if zeros.error is not None:
        report.problems.append(say("zero velocity ({error})", error=zeros.error))
    if programs is not None:
        programs.wait(report)
        if programs.ended:
            _zeros(run)  # they may have ended without sending zero
    report.standing = _standing(run, programs is not None and programs.drive_on)
    if missing := registrations.sentence():
        report.problems.append(missing)
    report.pending = [goal.description for goal in components.motions.goals if goal.end_due]


def _standing(run: StopRun, driven: bool) -> bool | None:
    """Return whether the robot stands still; where another program may drive it, it must for a second."""
    feeds, registrations = run.components.feeds, run.registrations
    try:
        feed = feeds.get("velocity").open()
        if not feed.publishers and registrations.lacks_publisher(feed.topic):
            registrations.miss(feed.topic)
            return None
        steady = _STEADY if driven else 0.0
        return feeds.wait_standing(max(_LOOK, run.deadline.remaining() or 0.0) + steady, steady=steady)
    except RosError as error:
        run.report.problems.append(say("checking whether it stands still ({error})", error=error))
        return None


def _zeros(run: StopRun) -> None:
    """Send zeros on both velocity topics, on each as soon as it has a subscriber."""
    velocity = run.components.velocity
    waiting: dict[str, rosproto.Publisher] = {}
    failed: dict[str, list[str]] = {}  # error -> topics: the same error is reported once
    for topic in VELOCITY_TOPICS.values():
        try:
            waiting[topic] = velocity.acquire(topic)
        except (RosError, OSError, RuntimeError) as error:
            failed.setdefault(str(error), []).append(topic)
    for why, topics in failed.items():
        problem = say("zero velocity on {topic} ({why})", topic=topics, why=say(why))
        run.report.problems.append(problem)
    acquired = list(waiting)
    try:
        _send_zeros(run, waiting)
    finally:
        for topic in acquired:
            velocity.release(topic)


def _send_zeros(run: StopRun, waiting: dict[str, rosproto.Publisher]) -> None:
    listeners = Deadline(max(_LISTENERS, run.deadline.remaining() or 0.0))
    sent: dict[str, int] = {}
    while waiting and any(sent.get(topic, 0) < ROUNDS for topic in waiting):
        for topic, publisher in list(waiting.items()):
            if publisher.connections and sent.get(topic, 0) < ROUNDS:
                run.components.velocity.zero(topic)
                sent[topic] = sent.get(topic, 0) + 1
            elif publisher.connections:
                continue
            elif sent.get(topic):
                del waiting[topic]  # the subscriber received some and has disconnected
            elif run.registrations.lacks_subscriber(topic):
                run.registrations.miss(topic)
                del waiting[topic]
            elif listeners.expired:
                run.report.problems.append(
                    say("zero velocity on {topic} (nobody has connected to it)", topic=topic)
                )
                del waiting[topic]
        time.sleep(0.05 if sent else 0.01)  # the first zero follows its subscriber at once
