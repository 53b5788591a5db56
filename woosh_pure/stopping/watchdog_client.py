"""Registers the motions of one `Chassis` at the watchdog process, which ends them if this program is killed.

The watchdog (`rosproto.watchdog`) has no code for a robot. The messages, calls and requests that it sends are
encoded here, before a motion begins.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from rosproto.codec import Message, encode
from rosproto.watchdog import LastCall, LastMessage, Watch, Watchdog
from woosh_pure.connection.connection import Connection
from woosh_pure.enums import TaskCommand
from woosh_pure.interface.table import row
from woosh_pure.values.messages import message_type, service_type

LIST_SECONDS = 3.0
"""For so long after the cancel of a task list, what the robot begins is cancelled, too."""


class WatchdogClient:
    """Registers motions when they begin and removes them when they end. Safe from any thread.

    Args:
        connection: The connection with our node.
        watchdog: The watchdog process; with None nothing is done.
        leave: True does not register goals, because they continue when the program ends.
    """

    def __init__(self, connection: Connection, watchdog: Watchdog | None, *, leave: bool) -> None:
        self._connection = connection
        self._watchdog = watchdog
        self._leave = leave
        self._watches: dict[Hashable, list[Watch]] = {}

    def drive(self, topic: str) -> None:
        """Register a velocity topic before a drive; wait until the watchdog can send zero to it."""
        if self._watchdog is not None and topic not in self._watches:
            zero = message_type(row(topic).type)()
            self._begin(topic, topic, zero, messages=(_last(topic, zero),))

    def goal(self, goal: Hashable, action: str, goal_id: str) -> None:
        """Register a goal before it is sent; wait until the watchdog can cancel it."""
        if self._watchdog is not None and not self._leave:
            cancel = message_type("actionlib_msgs/GoalID")(id=goal_id)
            self._begin(goal, action, None, messages=(_last(f"{action}/cancel", cancel),))

    def task(self, goal: Hashable, task_id: int) -> None:
        """Register a task before it is sent; wait until the watchdog can cancel it. 0: a task list."""
        if self._watchdog is not None and not self._leave:
            name = row("/exec_task").type
            request = service_type(name).Request(task_exect=int(TaskCommand.CANCEL), task_id=task_id)
            seconds = 0.0 if task_id else LIST_SECONDS
            last = LastCall("/exec_task", name, encode(request), seconds)
            self._begin(goal, "/exec_task", request, seconds, calls=(last,))

    def _begin(self, key: Hashable, name: str, message: Any, seconds: float = 0.0, **what: Any) -> None:
        assert self._watchdog is not None
        if (api := self._connection.robot_api) is not None:  # the master ends with this process
            from woosh_pure.robot_api.last_requests import last_request

            what = {"requests": (last_request(api, name, message, seconds),)}
        watch = self._watchdog.watch(self._connection.watched_node, **what)
        self._watches.setdefault(key, []).append(watch)

    def over(self, key: Hashable) -> None:
        """Remove the registrations of this goal or topic. Does not wait."""
        for watch in self._watches.pop(key, ()):
            watch.drop()


def _last(topic: str, message: Message) -> LastMessage:
    return LastMessage(topic, message._type, message._full_text, encode(message))
