"""`Progress`, the same for every verb, and `PlannedWay`, by which that of a drive is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from rosproto.codec import DynamicMessage
from woosh_pure.feed.feed import Feeds
from woosh_pure.geometry import Pose2D
from woosh_pure.values.messages import pose_of


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a goal has come; None for what is not known.

    Attributes:
        percent: Done part, %: of the way, or of the steps with equal weight for each.
        metres_left: The rest of the way, m.
        seconds: Since it began; until the end, when it has ended.
        pose: Where the robot is, in the map.
    """

    percent: float | None
    metres_left: float | None
    seconds: float
    pose: Pose2D | None


class PlannedWay:
    """The path that the navigation publishes for one drive (`/move_base/global_plan`).

    Args:
        feeds: Of the chassis; those of path and pose are opened, without waiting.

    Attributes:
        end: Ends listening; waits for nothing.
    """

    def __init__(self, feeds: Feeds) -> None:
        self._way: list[Pose2D] = []
        self._metres = 0.0  # of the first path
        feeds.get("pose").open()
        self.end = feeds.get("plan").on(self._receive, connect=False)

    def _receive(self, message: DynamicMessage) -> None:
        if message.header.frame_id.lstrip("/") in ("", "map"):
            self._way = way = [pose_of(one.pose, "map") for one in message.poses]
            self._metres = self._metres or sum(a.distance_to(b) for a, b in pairwise(way))

    def left(self, pose: Pose2D | None) -> tuple[float | None, float | None]:
        """Percent of the way that is done, and metres that are left of it."""
        metres = None if pose is None else length_left(self._way, pose)
        if metres is None or not self._metres:
            return None, None
        return max(0.0, 100.0 * (1.0 - metres / self._metres)), metres


def length_left(path: Sequence[Pose2D], here: Pose2D) -> float | None:
    """Return the distance in m to the nearest path point and on to its end; None without a path.

    If a path passes a place twice, the nearest point may belong to the other pass.
    """
    if len(path) < 2:
        return here.distance_to(path[0]) if path else None
    best = math.inf, 0.0  # (distance from the path, path left behind that point)
    behind = 0.0  # length of the segments that were looked at
    for a, b in reversed(list(pairwise(path))):
        length = a.distance_to(b)
        # The point of the segment that is nearest to `here` is `along` metres from its begin.
        along = ((here.x - a.x) * (b.x - a.x) + (here.y - a.y) * (b.y - a.y)) / length if length else 0.0
        along = min(max(along, 0.0), length)
        share = along / length if length else 0.0
        away = math.hypot(a.x + share * (b.x - a.x) - here.x, a.y + share * (b.y - a.y) - here.y)
        best = min(best, (away, behind + length - along))
        behind += length
    return sum(best)
