"""Goals that no server has mentioned yet: have they arrived, and what of those that arrive too late.

A goal is sent once, into one connection. When the server has given that connection up, which a silent network
does not tell us, the goal is lost and nobody says so: the status array goes on without it. actionlib (rospy's
and roscpp's) waits for ever then, because an array may be older than the goal. Here a server that has been
heard for a while without mentioning the goal does not have it: the goal is LOST.

It may still be on its way where the connection lives and TCP repeats what the network swallowed. Nobody
waits for such a goal any more, so it must not run: when a status array shows it, it is cancelled, and again
every second until the server reacts.

No I/O and no clock here; `ActionClient` does the talking and the locking.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosproto.bounded_cache import BoundedCache
from rosproto.protocol.goal_client import GoalStatus

__all__ = ["Arrivals"]

STEADY = 2.0  # seconds that a server is heard again before its silence about a goal counts
GAP = 1.0  # seconds without a status array that interrupt that; five are sent in one
AGAIN = 1.0  # seconds between two cancels of a goal that came too late
KEEP = 120.0  # seconds; by then every system has given up repeating what was sent
MOST_GIVEN_UP = 1000
MOST_SERVERS = 64  # node names that send status for one action; anybody may invent them

_RUNNING = (GoalStatus.PENDING, GoalStatus.ACTIVE)


class Arrivals:
    """What a client knows about servers that are heard and goals that are not."""

    def __init__(self) -> None:
        self._runs: BoundedCache[str, tuple[float, float]] = BoundedCache(
            MOST_SERVERS
        )  # heard since, heard last
        self._given_up: dict[str, tuple[float, float]] = {}  # goal id: forgotten at, cancelled again from

    def heard(self, server: str, now: float) -> None:
        """A status array of `server` came."""
        since, last = self._runs.get(server) or (now, now)
        self._runs.put(server, (now if now - last > GAP else since, now))

    def is_steady(self, server: str, now: float) -> bool:
        """True when `server` has been heard without a gap for long enough to be believed."""
        since, _ = self._runs.get(server) or (now, now)
        return now - since >= STEADY

    def give_up(self, goal_id: str, now: float) -> None:
        """Have the goal cancelled should it turn up."""
        if len(self._given_up) >= MOST_GIVEN_UP:
            del self._given_up[next(iter(self._given_up))]
        self._given_up[goal_id] = (now + KEEP, now)

    def too_late(self, mentioned: Mapping[str, Any], now: float) -> list[str]:
        """The goals given up that run after all, and are to be cancelled now.

        Args:
            mentioned: actionlib_msgs/GoalStatus by goal id: what a status array says.
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
