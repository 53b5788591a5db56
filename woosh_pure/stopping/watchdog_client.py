"""What the watchdog ends for one `Chassis` when this program is gone: our velocities, goals and tasks.

The watchdog itself (`rosproto.watchdog`) knows no robot; what it sends is made here, before a motion begins.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from rosproto.codec import encode
from rosproto.watchdog import LastCall, LastMessage, Watch, Watchdog
from woosh_pure.connection.connection import Connection
from woosh_pure.enums import TaskCommand
from woosh_pure.interface.table import row
from woosh_pure.values.messages import message_type, service_type


class WatchdogClient:
    """Tells the watchdog what begins and ends. Safe from any thread; without a watchdog it does nothing.

    Args:
        connection: Our node.
        watchdog: The process; None for none.
        leave: Goals go on when the program ends, and so they are not watched.
    """

    def __init__(self, connection: Connection, watchdog: Watchdog | None, *, leave: bool) -> None:
        self._connection = connection
        self._watchdog = watchdog
        self._leave = leave
        self._watches: dict[Hashable, list[Watch]] = {}

    def drive(self, topic: str) -> None:
        """Somebody is about to drive on a velocity topic; waits until the watchdog could send zero there."""
        if self._watchdog is not None and topic not in self._watches:
            self._begin(topic, messages=(_last(topic, message_type(row(topic).type)()),))

    def goal(self, goal: Hashable, action: str, goal_id: str) -> None:
        """A goal is about to be sent under this id; waits until the watchdog could cancel it."""
        if self._watchdog is not None and not self._leave:
            cancel = message_type("actionlib_msgs/GoalID")(id=goal_id)
            self._begin(goal, messages=(_last(f"{action}/cancel", cancel),))

    def task(self, goal: Hashable, task_id: int) -> None:
        """A task is about to be sent; waits until the watchdog could cancel it."""
        if self._watchdog is not None and not self._leave:
            name = row("/exec_task").type
            request = service_type(name).Request(task_exect=int(TaskCommand.CANCEL), task_id=task_id)
            self._begin(goal, calls=(LastCall("/exec_task", name, encode(request)),))

    def _begin(self, key: Hashable, **what: Any) -> None:
        assert self._watchdog is not None
        watch = self._watchdog.watch(self._connection.watched_node, **what)
        self._watches.setdefault(key, []).append(watch)

    def over(self, key: Hashable) -> None:
        """What was begun under this goal or topic is over. Waits for nothing."""
        for watch in self._watches.pop(key, ()):
            watch.drop()


def _last(topic: str, message: Any) -> LastMessage:
    return LastMessage(topic, message._type, message._full_text, encode(message))
