"""`Progress`, the same for every verb, and `PlannedWay`, by which that of a drive is known."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from rosproto.codec import DynamicMessage
from rosproto.sentence import say
from woosh_pure.feed.feed import Feeds
from woosh_pure.geometry import Pose2D
from woosh_pure.hints import PROGRESS, Hints
from woosh_pure.language import Spoken
from woosh_pure.values.messages import pose_of


@dataclass(frozen=True, slots=True)
class Progress(Spoken, Hints):
    """How far a goal has come; None for what is not known. `str()` is a line for people.

    Attributes:
        percent: Done part, %: of the way, or of the steps with equal weight for each.
        metres_left: The rest of the way, m.
        seconds: Since it began; until the end, when it has ended.
        pose: Where the robot is, in the map.
    """

    _hints = PROGRESS

    percent: float | None
    metres_left: float | None
    seconds: float
    pose: Pose2D | None

    def __str__(self) -> str:
        parts = [say("{seconds:.0f} s", seconds=self.seconds)]
        if (done := self.percent) is not None:
            way = say("{percent:.0f} %", percent=done)
            if self.metres_left:
                way = say("{text}, {metres:.1f} m left", text=way, metres=self.metres_left)
            if 2.0 < done < 100.0:  # the rest takes as long as the part that is done
                rest = self.seconds * (100.0 - done) / done
                way = say("{text}, about {seconds:.0f} s", text=way, seconds=rest)
            parts.append(way)
        if (here := self.pose) is not None:
            where = say("x {x:.2f} m, y {y:.2f} m, {yaw:.0f}°", x=here.x, y=here.y, yaw=here.yaw_degrees)
            parts.append(say("at {where}", where=where))
        return functools.reduce(lambda a, b: say("{first}   {second}", first=a, second=b), parts)


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
