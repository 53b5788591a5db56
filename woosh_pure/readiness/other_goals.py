"""Goals of other clients on the action servers that move the base, read from the servers' own status.

A goal's id begins with the name of the node that sent it; roscpp, rospy and rosproto all form ids this way.
"""

from __future__ import annotations

import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

from woosh_pure.values.rostypes import message_type

if TYPE_CHECKING:
    import rosproto

__all__ = ["ROBOT_ITSELF", "OtherGoals"]

ROBOT_ITSELF = "/ros_interface"
"""The chassis's own node that carries out tasks, which is a client of the action servers."""

_ACTIONS = ("/move_base", "/cmd_vel_control")
_UNDER_WAY = (0, 1, 6, 7)  # actionlib_msgs/GoalStatus: pending, active, preempting, recalling
_FIRST_STATUS = 0.5  # seconds: a server sends its status 5 times a second
_STALE = 3.0


class OtherGoals:
    """Keeps track of who else has a goal under way. Subscribes on first use; safe from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._own_name = ""
        self._heard: dict[str, tuple[float, tuple[str, ...]]] = {}
        self._opened = False

    def listen(self, node: rosproto.Node) -> None:
        """Subscribe to the status of the servers; the first call waits briefly for the first status."""
        with self._lock:
            opened, self._opened = self._opened, True
        if opened:
            return
        from rosproto.transport import Deadline  # late: this module must be importable without sockets

        self._own_name = node.name
        status = message_type("actionlib_msgs/GoalStatusArray")
        subscribers = [
            node.subscriber(f"{name}/status", status, callback=partial(self.receive, name), queue_size=1)
            for name in _ACTIONS
        ]
        deadline = Deadline(_FIRST_STATUS)
        while not deadline.expired and not all(
            name in self._heard or all(link.last_error for link in subscriber.stats())
            for name, subscriber in zip(_ACTIONS, subscribers, strict=True)
        ):
            time.sleep(0.01)

    def receive(self, action: str, message: Any) -> None:
        """Take in one actionlib_msgs/GoalStatusArray."""
        active = tuple(s.goal_id.id for s in message.status_list if s.status in _UNDER_WAY)
        with self._lock:
            self._heard[action] = (time.monotonic(), active)

    def active(self) -> list[tuple[str, str]]:
        """(client, action) of every goal under way that is not ours; `ROBOT_ITSELF` for the robot's tasks."""
        now = time.monotonic()
        with self._lock:
            heard = [(action, ids) for action, (at, ids) in self._heard.items() if now - at < _STALE]
        owners = [(_client_of(goal_id), action) for action, ids in heard for goal_id in ids]
        return [(who, what) for who, what in owners if who != self._own_name]


def _client_of(goal_id: str) -> str:
    """The node in an id "<node>-<number>-<time>"; the id itself when it has another form."""
    name, _, rest = goal_id.partition("-")
    return name if rest else goal_id
