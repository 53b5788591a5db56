"""Stopping what other clients move: cancel tasks and goals, name programs that drive by velocity or end them.

The master's registrations are read once, in the background, so that a missing node is reported at once
instead of being waited for.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import rosproto
from rosproto.codec import DynamicMessage
from rosproto.errors import RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node import NodeClient, SystemState
from rosproto.sentence import say
from rosproto.transport import Deadline, HostNames
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.connection.connection import Connection
from woosh_pure.connection.other_drivers import OtherDriver, other_drivers
from woosh_pure.enums import TaskCommand
from woosh_pure.interface.table import actions
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.stop_executor import Job, begin
from woosh_pure.values.messages import message_type

if TYPE_CHECKING:
    from woosh_pure.components import Components

logger = get_logger("woosh_pure.stop")
_ANSWER = 2.0  # seconds that the master has at least
_TASK_FIRST = 0.5
_MIN_STEP_SECONDS = 1.0
"""Seconds that every step may take, however near the deadline is."""
_LOOK_AGAIN, _LONGER = 0.5, 10.0
_FIRST_STATUS = 1.0  # seconds: a server sends its status 5 times a second
_CANCEL_AGAIN = 0.5  # seconds after which a goal that is still under way is cancelled once more
_READ = 1.0  # seconds for a subscriber to read the last message
_UNDER_WAY = (0, 1)  # of actionlib_msgs/GoalStatus: pending, active
_HAD_A_GOAL = (*_UNDER_WAY, 2, 6, 7, 8)  # and cancelled ones


class Registrations:
    """The registrations of other nodes at the master, and a list of those that are missing.

    Until the master has answered, nothing counts as missing. Safe from any thread.

    Args:
        connection: The connection to the master.
        deadline: The master is asked at least until then: a busy one answers late.

    Attributes:
        missing: Names without a node, in the order of the calls of `miss`.
    """

    def __init__(self, connection: Connection, deadline: Deadline) -> None:
        self._connection = connection
        self._seconds = max(_ANSWER, deadline.remaining() or 0.0)
        self._state: SystemState | None = None
        self._own_name = ""
        self._lock = threading.Lock()
        self.missing: list[str] = []
        self._asking = Job(self._ask, self._seconds)
        begin(self._asking, "woosh:registrations")

    def _ask(self) -> None:
        try:
            node = self._connection.open_node()
            self._own_name = node.name
            self._state = node.master.get_system_state(timeout=self._seconds)
        except (RosError, OSError, RuntimeError) as error:
            logger.debug("! who is there is not known: %s", error)

    def wait(self, timeout: float) -> bool:
        """Wait at most `timeout` seconds for the master's answer; return whether it has come."""
        self._asking.join(timeout)
        return self._state is not None

    def subscribers(self, topic: str) -> int:
        """How many other nodes subscribe to the topic, by the master's answer."""
        return 0 if self._state is None else len(self._others(self._state.subscribers.get(topic, ())))

    def lacks_publisher(self, topic: str) -> bool:
        """Whether the master has answered and no other node publishes the topic."""
        return self._state is not None and not self._others(self._state.publishers.get(topic, ()))

    def lacks_subscriber(self, topic: str) -> bool:
        """Whether the master has answered and no other node subscribes to the topic."""
        return self._state is not None and not self._others(self._state.subscribers.get(topic, ()))

    def lacks_service(self, name: str) -> bool:
        """Whether the master has answered and no node offers the service."""
        return self._state is not None and name not in self._state.services

    def _others(self, nodes: Iterable[str]) -> list[str]:
        return [node for node in nodes if node != self._own_name]

    def miss(self, name: str) -> None:
        """Add the name of a topic, service or action to `missing`."""
        with self._lock:
            self.missing.append(name)

    def sentence(self) -> str:
        """Return `missing` as a sentence; "" if it is empty."""
        if not self.missing:
            return ""
        master_uri = self._connection.master_uri
        return say(
            "no node provides {names} at {uri}: no chassis runs there, or not all of it; try `woosh doctor`",
            names=sorted(self.missing),
            uri=master_uri,
        )


# -- tasks and goals -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StopRun:
    """One stop under way: what its steps share.

    Attributes:
        components: The chassis.
        registrations: Missing nodes are not waited for.
        report: Successes and failures are added to it.
        deadline: What has not answered by then is reported.
    """

    components: Components
    registrations: Registrations
    report: StopReport
    deadline: Deadline


def cancel_others(run: StopRun) -> None:
    """Cancel the robot's task, and every goal of the action servers that move it, whoever sent it."""
    report, registrations, deadline = run.report, run.registrations, run.deadline
    told = _begin(partial(_tell_others, run), deadline)
    # The task is cancelled first: it would end as failed if its navigation was cancelled before. The wait is
    # short, because the navigation is cancelled in any case.
    task = _begin(partial(_cancel_task, run), deadline)
    registrations.wait(_TASK_FIRST)
    task.join(_TASK_FIRST)
    waiting, cancelled = {"the task": task}, list[str]()
    report.looked = True
    for row in actions():
        # Servers that every chassis has, and those of the others that are registered.
        if not row.moves_base or (
            row.source != "page" and registrations.lacks_subscriber(f"{row.name}/cancel")
        ):
            continue
        waiting[row.name] = _begin(partial(_cancel_action, run, row.name, cancelled), deadline)
    for name, worker in waiting.items():
        worker.join(_left(deadline) + 0.5)
        if not worker.over:
            report.problems.append(say("cancelling {goal} (no answer yet)", goal=name))
    told.join(_left(deadline))
    if cancelled:
        report.cancelled.append(say("all goals of {server}", server=", ".join(sorted(cancelled))))


STOPPED = "/woosh_pure/stopped"
"""std_msgs/Empty: a stop of everything. While nothing moves, no topic of the robot shows it. Cancels and
velocities are not listened to: a program that stops could take our connection for that of the robot."""


def hear_stops(node: rosproto.Node, scope: CallScope) -> None:
    """Count each `stop(everything=True)` of other programs as a stop of the scope's Chassis, from now on."""

    def hear(message: DynamicMessage) -> None:
        if scope.motions is not None and (message._connection_header or {}).get("callerid") != node.name:
            scope.motions.note_stop("another program stopped the robot")

    node.subscriber(STOPPED, message_type("std_msgs/Empty"), callback=hear)


def _tell_others(run: StopRun) -> None:
    run.registrations.wait(_ANSWER)
    if not (listeners := run.registrations.subscribers(STOPPED)):
        return
    told, deadline = (
        threading.Semaphore(0),
        Deadline(_FIRST_STATUS),
    )  # a program that hears it may end at once
    try:
        node = run.components.connection.open_node()
        empty = message_type("std_msgs/Empty")
        with node.publisher(STOPPED, empty, latch=True, on_connect=lambda _: told.release()) as publisher:
            publisher.publish()
            late = sum(not told.acquire(timeout=deadline.remaining() or 0.0) for _ in range(listeners))
            publisher.close(wait=_READ)
        if late:
            why = "{late} of {count} did not connect; they may have ended without unregistering"
            raise RosError(say(why, late=late, count=listeners))
    except (RosError, OSError, RuntimeError) as error:
        logger.warning("! other programs are not told that the robot was stopped: %s", error)


def _left(deadline: Deadline) -> float:
    return max(_MIN_STEP_SECONDS, deadline.remaining() or 0.0)


def _begin(work: Callable[[], None], deadline: Deadline) -> Job[None]:
    job = Job(work, _left(deadline) + _LONGER)
    begin(job, "woosh:cancel")
    return job


def _cancel_action(run: StopRun, name: str, cancelled: list[str]) -> None:
    """Cancel all goals: an empty id and a zero time (wiki.ros.org/actionlib/DetailedDescription).

    Those that are still under way afterwards are cancelled again, by their ids: a goal that somebody sends
    after the stop is not meant. An action client is not used, because its five topics would have to be
    registered first.
    """
    topic, registrations = f"{name}/cancel", run.registrations
    registrations.wait(_ANSWER)  # costs nothing: without the master nobody connects to the topic
    if registrations.lacks_subscriber(topic):
        registrations.miss(name)
        return
    try:
        node, status = run.components.connection.open_node(), message_type("actionlib_msgs/GoalStatusArray")
        statuses = node.subscriber(f"{name}/status", status, queue_size=1)
        goal_id = message_type("actionlib_msgs/GoalID")
        with node.publisher(topic, goal_id, queue_size=1) as publisher, statuses:
            publisher.wait_for_connection(timeout=_left(run.deadline))
            publisher.publish()
            publisher.flush(1.0)
            goals = (
                None if registrations.lacks_publisher(statuses.topic) else goals_of(statuses, _FIRST_STATUS)
            )
            if goals is None or any(status in _HAD_A_GOAL for status in goals.values()):
                cancelled.append(name)
            if not cancel_by_id(publisher, statuses, goals, Deadline(_left(run.deadline))):
                run.report.problems.append(say("cancelling {goal} (it goes on)", goal=name))
            publisher.close(wait=_READ)
    except (RosError, OSError, RuntimeError) as error:
        run.report.problems.append(say("cancelling {goal} ({error})", goal=name, error=error))


def goals_of(statuses: rosproto.Subscriber, seconds: float) -> dict[str, int] | None:
    """Return the status of each goal by its id, from the server's next message; None if none comes."""
    try:
        return {goal.goal_id.id: goal.status for goal in statuses.next(seconds).status_list}
    except RosError:
        return None


def cancel_by_id(
    publisher: rosproto.Publisher,
    statuses: rosproto.Subscriber,
    goals: dict[str, int] | None,
    deadline: Deadline,
) -> bool:
    """Cancel the goals that are under way until they no longer are; False if some are at the deadline.

    A cancel may be lost: its connection ended before it was read.
    """
    left = {id for id, status in (goals or {}).items() if status in _UNDER_WAY}
    again = time.monotonic() + _CANCEL_AGAIN
    while left and not deadline.expired:
        if time.monotonic() >= again:
            for id in left:
                publisher.publish(id=id)
            again = time.monotonic() + _CANCEL_AGAIN
        if (now := goals_of(statuses, _CANCEL_AGAIN)) is not None:
            left &= {id for id, status in now.items() if status in _UNDER_WAY}
    return not left


def _cancel_task(run: StopRun) -> None:
    components, report = run.components, run.report
    try:
        status = components.feeds.get("status").latest
    except RosError:
        status = None
    if status is not None and not status.task_state.is_under_way:
        return
    run.registrations.wait(_ANSWER)
    if run.registrations.lacks_service("/exec_task"):
        run.registrations.miss("/exec_task")
        return
    task_id = 0 if status is None else status.task_id
    try:
        reply = components.clients.exec_task(TaskCommand.CANCEL, task_id, timeout=_left(run.deadline))
        if reply.success:
            report.cancelled.append(
                say("task {id}", id=task_id) if status is not None else say("the running task")
            )
    except (RosError, OSError, RuntimeError) as error:
        report.problems.append(say("cancelling the task ({error})", error=error))


# -- programs that drive by velocity -------------------------------------------------------------------------


class OtherPrograms:
    """Other programs that publish velocities, without the robot's own nodes and programs on its computer.

    They are examined twice, in the background: their message counters show whether they send.

    Args:
        connection: The connection to the graph.
        deadline: Time limit for the programs to end.
        end: True asks them to end (`shutdown` of wiki.ros.org/ROS/Slave_API, as `rosnode kill` does).
    """

    def __init__(self, connection: Connection, deadline: Deadline, *, end: bool) -> None:
        self._connection = connection
        self._deadline = deadline
        self._end = end
        self._left: dict[str, tuple[OtherDriver, bool]] = {}
        self._ended: list[str] = []
        self._asked: set[tuple[str, str]] = set()  # name and address: a restarted one has another address
        self._problem = ""
        self._looking = _begin(self._look, deadline)

    @property
    def drive_on(self) -> bool:
        """Whether a program remains that may drive the robot again."""
        return bool(self._left)

    @property
    def ended(self) -> bool:
        """Whether programs have ended, perhaps without sending a last zero."""
        return bool(self._ended)

    def wait(self, report: StopReport) -> None:
        """Wait, with a time limit, for the examination, and add its results to the report."""
        self._looking.join(_left(self._deadline) + 0.5)
        if not self._looking.over and not self._left:
            self._problem = "looking for other programs that drive by velocity (no answer yet)"
        report.cancelled += [say("the program {name}", name=name) for name in self._ended]
        for driver, sends in self._left.values():
            asked = (driver.node, driver.uri) in self._asked
            if asked:
                problem = say(
                    "{driver}, it was asked to end and has not", driver=driver.sentence(sends=sends)
                )
            else:
                only = "{driver}, which stops only when that program ends: {how}"
                problem = say(only, driver=driver.sentence(sends=sends), how=_HOW)
            report.problems.append(problem)
        if self._problem:
            report.problems.append(self._problem)

    def _look(self) -> None:
        try:
            first = self._others()
            self._left = {name: (driver, False) for name, driver in first.items()}
            if not first:
                return
            if self._end:
                left = self._end_all(first)
            else:
                time.sleep(_LOOK_AGAIN)
                left = self._others()
            self._left = {
                name: (driver, driver.has_sent_since(first.get(name))) for name, driver in left.items()
            }
        except (RosError, OSError, RuntimeError) as error:
            self._problem = say("looking for other programs that drive by velocity ({error})", error=error)

    def _others(self) -> dict[str, OtherDriver]:
        return {
            driver.node: driver
            for driver in other_drivers(self._connection.open_node())
            if not driver.on_robot
        }

    def _end_all(self, drivers: dict[str, OtherDriver]) -> dict[str, OtherDriver]:
        """Ask the programs to end, and any that are started after them; return those left at the deadline.

        A woosh_pure program that ends sends its last zeros from a temporary node, which must not be
        disturbed. So a new node is asked only after it has existed for a moment, as a restarted program has.
        """
        deadline = Deadline(_left(self._deadline))
        came = {(driver.node, driver.uri): -math.inf for driver in drivers.values()}
        left = drivers
        while left and not deadline.expired:
            for driver in left.values():
                key = driver.node, driver.uri
                since = came.setdefault(key, time.monotonic())
                if key not in self._asked and time.monotonic() - since >= _LOOK_AGAIN:
                    self._asked.add(key)
                    self._ask_to_end(driver)
            try:
                left = self._others()
            except RosTimeout:  # a busy master: it is asked again
                if deadline.expired:
                    raise
            if left:
                time.sleep(0.05)
        asked = dict.fromkeys(key[0] for key in came if key in self._asked)
        self._ended = [name for name in asked if name not in left]
        return left

    def _ask_to_end(self, driver: OtherDriver) -> None:
        ours = self._connection.open_node()
        try:
            # Never at the master's address for a name that is not known: another node may have that port.
            with NodeClient(driver.uri, ours.name, timeout=1.0, hosts=HostNames(ours.hosts.given)) as node:
                node.shutdown("woosh: the robot is to stop")
        except (RosError, ValueError):
            pass  # the next look shows that it still runs


_HOW = "end it (end_drivers=True, `woosh stop --end-drivers`)"
