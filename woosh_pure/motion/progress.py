"""`Progress`, the same for every verb, and `PlannedWay`, by which that of a drive is known."""

from __future__ import annotations

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
        way = self._way
        if pose is None or len(way) < 2 or not self._metres:
            return None, None
        legs = [a.distance_to(b) for a, b in pairwise(way)]
        away = [pose.distance_to(place) for place in way]
        # The robot is on the leg that is hardly longer by way of the robot.
        here = min(range(len(legs)), key=lambda leg: away[leg] + away[leg + 1] - legs[leg])
        metres = away[here + 1] + sum(legs[here + 1 :])
        return max(0.0, 100.0 * (1.0 - metres / self._metres)), metres
