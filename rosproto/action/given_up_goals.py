"""Goals that no server has acknowledged: when they count as lost, and their cancellation if they arrive late.

A goal is sent once, over one connection. If the server has dropped that connection and the network did not
report it, the goal is lost without any sign: status arrays keep coming without it. actionlib (rospy's and
roscpp's) then waits for ever, because an array may be older than the goal. Here the goal is LOST once a
server has been heard for a while without mentioning it.

Such a goal may still arrive if the connection is alive and TCP retransmits. It must not run without a waiting
client: once a status array lists it, it is cancelled, every second until the server reacts.

No I/O and no clock here; `GoalTracker` passes the times and holds the lock.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosproto.bounded_cache import BoundedCache
from rosproto.protocol.goal_status import GoalStatus

STEADY = 2.0  # seconds that a server must be heard without a gap until its silence about a goal counts
GAP = 1.0  # seconds without a status array that make a gap; five are sent each second
AGAIN = 1.0  # seconds between two cancels of a goal that arrived too late
KEEP = 120.0  # seconds; by then every system has given up retransmitting
MOST_GIVEN_UP = 1000
MOST_SERVERS = 64  # node names that send status for one action; peers choose their names

_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE)


class GivenUpGoals:
    """Which servers are heard steadily, and which goals were given up."""

    def __init__(self) -> None:
        self._runs: BoundedCache[str, tuple[float, float]] = BoundedCache(
            MOST_SERVERS
        )  # heard since, heard last
        self._given_up: dict[str, tuple[float, float]] = {}  # goal id: forgotten at, cancelled again from

    def heard(self, server: str, now: float) -> None:
        """A status array of `server` arrived."""
        since, last = self._runs.get(server) or (now, now)
        self._runs.put(server, (now if now - last > GAP else since, now))

    def is_steady(self, server: str, now: float) -> bool:
        """True when `server` has been heard without a gap for `STEADY` seconds."""
        since, _ = self._runs.get(server) or (now, now)
        return now - since >= STEADY

    def give_up(self, goal_id: str, now: float) -> None:
        """Have the goal cancelled if it appears in a status array."""
        if len(self._given_up) >= MOST_GIVEN_UP:
            del self._given_up[next(iter(self._given_up))]
        self._given_up[goal_id] = (now + KEEP, now)

    def too_late(self, mentioned: Mapping[str, Any], now: float) -> list[str]:
        """Goals that were given up but run after all, and have to be cancelled now.

        Args:
            mentioned: The actionlib_msgs/GoalStatus entries of a status array, by goal id.
        """
        due = []
        for goal_id, (forget, again) in list(self._given_up.items()):
            status = mentioned.get(goal_id)
            if now >= forget or (status is not None and status.status not in _RUNNING):
                del self._given_up[goal_id]
            elif status is not None and now >= again:
                self._given_up[goal_id] = (forget, now + AGAIN)
                due.append(goal_id)
        return due
