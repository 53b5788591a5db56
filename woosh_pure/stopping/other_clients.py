"""Stopping what others have started: tasks and goals are cancelled; programs that drive by velocity cannot
be, so they are named, or asked to end.

Who is registered at the master is asked once, in the background: what nobody is registered for is reported at
once, instead of being waited for.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Protocol

import rosproto
from rosproto.errors import RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node import NodeClient, SystemState
from rosproto.sentence import say
from rosproto.transport import Deadline, HostNames
from woosh_pure.connection.clients import Clients
from woosh_pure.connection.connection import Connection
from woosh_pure.connection.other_drivers import OtherDriver, other_drivers
from woosh_pure.connection.velocity_topics import VelocityTopics
from woosh_pure.enums import TaskCommand, TaskState
from woosh_pure.feed.feeds import Feeds
from woosh_pure.interface.table import actions
from woosh_pure.stopping.active_motions import ActiveMotions
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.stop_executor import Job, begin
from woosh_pure.values.messages import message_type

logger = get_logger("woosh_pure.stop")
_ANSWER = 2.0  # seconds for the master
_TASK_FIRST = 0.5
_LEAST = 1.0
"""Seconds that every step may take, however near the deadline is."""
_LOOK_AGAIN, _LONGER = 0.5, 10.0
_FIRST_STATUS = 1.0  # seconds: a server sends its status 5 times a second
_HAD_A_GOAL = (0, 1, 2, 6, 7, 8)  # of actionlib_msgs/GoalStatus: pending, active, and cancelled ones
_UNDER_WAY = (TaskState.RUNNING, TaskState.PAUSED, TaskState.WAITING_FOR_ACTION)


class StopParts(Protocol):
    """What a stop works with: these parts of `woosh_pure.components.Components`, which stands above."""

    @property
    def connection(self) -> Connection: ...

    @property
    def clients(self) -> Clients: ...

    @property
    def feeds(self) -> Feeds: ...

    @property
    def velocity(self) -> VelocityTopics: ...

    @property
    def motions(self) -> ActiveMotions: ...


class Registrations:
    """Topics and services that somebody other than us has, and those that were found missing.

    While the master has not answered nothing counts as missing: links stand without it. Safe from any thread.

    Args:
        connection: Whose master is asked.

    Attributes:
        missing: Names that nobody is there for, in the order of `miss`.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._state: SystemState | None = None
        self._own_name = ""
        self._lock = threading.Lock()
        self.missing: list[str] = []
        self._asking = Job(self._ask, _ANSWER)
        begin(self._asking, "woosh:registrations")

    def _ask(self) -> None:
        try:
            node = self._connection.open_node()
            self._own_name = node.name
            self._state = node.master.get_system_state(timeout=_ANSWER)
        except (RosError, OSError, RuntimeError) as error:
            logger.debug("! who is there is not known: %s", error)

    def wait(self, timeout: float) -> bool:
        """Wait, with a bound, for the master's answer; whether it has come."""
        self._asking.join(timeout)
        return self._state is not None

    def lacks_publisher(self, topic: str) -> bool:
        """True when the master has answered, and nobody publishes the topic."""
        return self._state is not None and not self._others(self._state.publishers.get(topic, ()))

    def lacks_subscriber(self, topic: str) -> bool:
        """True when the master has answered, and nobody subscribes to the topic."""
        return self._state is not None and not self._others(self._state.subscribers.get(topic, ()))

    def lacks_service(self, name: str) -> bool:
        """True when the master has answered, and nobody offers the service."""
        return self._state is not None and name not in self._state.services

    def _others(self, nodes: Iterable[str]) -> list[str]:
        return [node for node in nodes if node != self._own_name]

    def miss(self, name: str) -> None:
        """Note that nobody is there for a topic, service or action."""
        with self._lock:
            self.missing.append(name)

    def sentence(self) -> str:
        """What was missed, in words; "" when nothing was."""
        if not self.missing:
            return ""
        master_uri = self._connection.master_uri
        return say(
            "nobody is there for {names} at {uri}: no chassis runs there, or not all of it; try `woosh "
            "doctor`",
            names=sorted(self.missing),
            uri=master_uri,
        )


# -- tasks and goals -----------------------------------------------------------------------------------------


def cancel_others(
    components: StopParts, registrations: Registrations, report: StopReport, deadline: Deadline
) -> None:
    """Cancel the robot's task, and every goal of the action servers that move it, whoever sent it.

    Args:
        components: The chassis.
        registrations: What is not there is not waited for.
        report: Takes what was done, and what was not.
        deadline: What has not answered by then is told.
    """
    # A task ends as cancelled when it is told so first, and as failed when its navigation is taken from it.
    # But nobody waits long for that: the navigation is stopped anyway.
    task = _begin(partial(_cancel_task, components, registrations, report, deadline), deadline)
    registrations.wait(_TASK_FIRST)
    task.join(_TASK_FIRST)
    waiting, cancelled = {"the task": task}, list[str]()
    report.looked = True
    for row in actions():
        # Those that every chassis has; the others where they are there.
        if not row.moves_base or (
            row.source != "page" and registrations.lacks_subscriber(f"{row.name}/cancel")
        ):
            continue
        waiting[row.name] = _begin(
            partial(_cancel_action, components, registrations, row.name, report, cancelled, deadline),
            deadline,
        )
    for name, worker in waiting.items():
        worker.join(_left(deadline) + 0.5)
        if not worker.over:
            report.problems.append(say("cancelling {goal} (no answer yet)", goal=name))
    if cancelled:
        report.cancelled.append(say("all goals of {server}", server=", ".join(sorted(cancelled))))


def _left(deadline: Deadline) -> float:
    return max(_LEAST, deadline.remaining() or 0.0)


def _begin(work: Callable[[], None], deadline: Deadline) -> Job[None]:
    job = Job(work, _left(deadline) + _LONGER)
    begin(job, "woosh:cancel")
    return job


def _cancel_action(
    components: StopParts,
    registrations: Registrations,
    name: str,
    report: StopReport,
    cancelled: list[str],
    deadline: Deadline,
) -> None:
    """The empty id and no time mean all goals (wiki.ros.org/actionlib/DetailedDescription). Without a client:
    its five topics would be registered first.
    """
    topic = f"{name}/cancel"
    if registrations.lacks_subscriber(topic):
        registrations.miss(name)
        return
    try:
        told = _begin_listening(components, name)
        goal_id = message_type("actionlib_msgs/GoalID")
        with components.connection.open_node().publisher(topic, goal_id, queue_size=1) as publisher, told:
            publisher.wait_for_connection(timeout=_left(deadline))
            publisher.publish()
            publisher.flush(1.0)
            if registrations.lacks_publisher(told.topic) or _ran(told):
                cancelled.append(name)
    except (RosError, OSError, RuntimeError) as error:
        report.problems.append(say("cancelling {goal} ({error})", goal=name, error=error))


def _begin_listening(components: StopParts, name: str) -> rosproto.Subscriber:
    return components.connection.open_node().subscriber(
        f"{name}/status", message_type("actionlib_msgs/GoalStatusArray"), queue_size=1
    )


def _ran(status: rosproto.Subscriber) -> bool:
    """Whether a server had a goal, by the first status that it sends; yes when it says nothing.

    That may come after the cancel: then a goal that was preempted just now is taken for the one.
    """
    try:
        goals = status.next(_FIRST_STATUS).status_list
    except RosError:
        return True
    return any(goal.status in _HAD_A_GOAL for goal in goals)


def _cancel_task(
    components: StopParts, registrations: Registrations, report: StopReport, deadline: Deadline
) -> None:
    try:
        status = components.feeds.get("status").latest
    except RosError:
        status = None
    if status is not None and status.task_state not in _UNDER_WAY:
        return
    if registrations.lacks_service("/exec_task"):
        registrations.miss("/exec_task")
        return
    task_id = 0 if status is None else status.task_id
    try:
        reply = components.clients.exec_task(TaskCommand.CANCEL, task_id, timeout=_left(deadline))
        if reply.success:
            report.cancelled.append(
                say("task {id}", id=task_id) if status is not None else say("the running task")
            )
    except (RosError, OSError, RuntimeError) as error:
        report.problems.append(say("cancelling the task ({error})", error=error))


# -- programs that drive by velocity -------------------------------------------------------------------------


class OtherPrograms:
    """Programs that can send velocities, too, looked at twice in the background: their counters tell whether
    they do. The robot's own nodes are left out, and so is what runs on its computer.

    Args:
        connection: Whose graph is looked at.
        deadline: For them to end.
        end: Ask them to end (`shutdown` of wiki.ros.org/ROS/Slave_API, as `rosnode kill` does).
    """

    def __init__(self, connection: Connection, deadline: Deadline, *, end: bool) -> None:
        self._connection = connection
        self._deadline = deadline
        self._end = end
        self._left: dict[str, tuple[OtherDriver, bool]] = {}
        self._ended: list[str] = []
        self._asked: set[tuple[str, str]] = set()  # name and address: one that was started anew has another
        self._problem = ""
        self._looking = _begin(self._look, deadline)

    @property
    def drive_on(self) -> bool:
        """Whether the robot may stand for a moment only."""
        return bool(self._left)

    @property
    def ended(self) -> bool:
        """Whether some were there that have ended now, perhaps without a last zero."""
        return bool(self._ended)

    def wait(self, report: StopReport) -> None:
        """Wait, with a bound, until all was looked at, and tell of it."""
        self._looking.join(_left(self._deadline) + 0.5)
        if not self._looking.over and not self._left:
            self._problem = "looking for other programs that drive by velocity (no answer yet)"
        report.cancelled += [say("the program {name}", name=name) for name in self._ended]
        for driver, sends in self._left.values():
            asked = (driver.node, driver.uri) in self._asked
            if asked:
                told = say("{driver}, it was asked to end and has not", driver=driver.sentence(sends=sends))
            else:
                only = "{driver}, which only its end stops: {how}"
                told = say(only, driver=driver.sentence(sends=sends), how=_HOW)
            report.problems.append(told)
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
        """Ask them to end, and who comes after them; those that are still there at the deadline.

        One of ours that is asked sends its last zeros from another node, which is there for a moment and is
        not disturbed. A program that something starts again is there for longer.
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
            except RosTimeout:  # a busy master: there is time to ask it again
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
            pass  # that it is still there will be seen


_HOW = "end it (end_drivers=True, `woosh stop --end-drivers`)"
