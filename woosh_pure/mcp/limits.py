"""Where and how an assistant may move the robot: judges a target, and poses and paths on the way. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.motion.steps import MAX_SPEED

MAX_MOTION_SECONDS, DISTANCE_SLACK, SPEED_SLACK = 3600.0, 0.05, 0.05
"""s; m and m/s by which a measured place and speed may exceed the limits."""
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of each motion, kept by the server.

    Attributes:
        only_marks: Only drives to known marks; no poses, steps or turns.
        area: Corners of the area that must not be left, m in the map; () for none. The robot's centre counts.
        max_distance: How far from where a motion begins it may lead, m; None for no limit.
        max_speed: m/s; None for no limit.
        max_seconds: After so many seconds a motion is ended.

    Raises:
        ValueError: A limit makes no sense.
    """

    only_marks: bool = False
    area: tuple[Point, ...] = ()
    max_distance: float | None = None
    max_speed: float | None = None
    max_seconds: float = 120.0

    def __post_init__(self) -> None:
        most = {"max_distance": math.inf, "max_speed": MAX_SPEED, "max_seconds": MAX_MOTION_SECONDS}
        for name, maximum in most.items():
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and 0.0 < value <= maximum):
                wrong = "{name}={value}: expected more than 0 and at most {maximum:g}"
                raise ValueError(say(wrong, name=name, value=value, maximum=maximum))
        if 0 < len(self.area) < 3 or not all(math.isfinite(x) and math.isfinite(y) for x, y in self.area):
            raise ValueError("an area has at least three corners, each of two finite numbers in m")

    @property
    def by_place(self) -> bool:
        """Whether the place of the robot must be known."""
        return bool(self.area) or self.max_distance is not None

    def refusal(self, here: Pose2D | None, target: Pose2D | None, *, straight: bool = False) -> str:
        """Why a motion to a target is refused; "" if it is not. Poses are in the map, None if not known.

        Args:
            here, target: Where the robot is, and where it would be at the end.
            straight: Whether it would go there in a straight line.
        """
        if not self.by_place:
            return ""
        if here is None or target is None:
            what = "where the robot is" if here is None else "the place of the target"
            return say("{what} is not known now, so the limits cannot be kept", what=say(what))
        return self.leaves(here, [here, target], slack=0.0, lines=straight)

    def leaves(
        self, start: Pose2D, way: Sequence[Pose2D], *, slack: float = DISTANCE_SLACK, lines: bool = True
    ) -> str:
        """Why a way breaks the limits of a motion that began at `start`; "" if it does not.

        Args:
            start, way: Poses.
            slack: m that it may lead farther away.
            lines: Whether the lines between the poses count, too.
        """
        for pose in way:
            if not (math.isfinite(pose.x) and math.isfinite(pose.y)) or pose.frame.lstrip("/") != "map":
                return "a place is not known in the map, so the limits cannot be kept"
            if self.max_distance is not None and (far := start.distance_to(pose)) > self.max_distance + slack:
                wrong = "{far:.2f} m from where it began; {maximum:g} m are allowed"
                return say(wrong, far=far, maximum=self.max_distance)
            if self.area and not contains(self.area, pose):
                return say("x {x:.2f} m, y {y:.2f} m is outside the allowed area", x=pose.x, y=pose.y)
        points = [(pose.x, pose.y) for pose in way] if lines else []
        if any(_cross(a, b, *edge) for edge in _edges(self.area) for a, b in pairwise(points)):
            return "the way leaves the allowed area"
        return ""


def area_of(text: str) -> tuple[Point, ...]:
    """The corners of an area file: a line `X,Y` for each, m in the map; `#` begins a comment.

    Raises:
        ValueError: It is not such a file.
    """
    lines = [line.partition("#")[0].replace(",", " ").split() for line in text.splitlines()]
    try:
        area = tuple((float(x), float(y)) for x, y in filter(None, lines))
    except ValueError:
        raise ValueError("an area file has a line X,Y for each corner, in metres, such as 1.5,-2") from None
    return Limits(area=area or ((0.0, 0.0),)).area


def contains(area: Sequence[Point], pose: Pose2D) -> bool:
    """Whether a place is inside a polygon (even-odd rule)."""
    above = [(a, b) for a, b in _edges(area) if (a[1] > pose.y) != (b[1] > pose.y)]
    right = [a for a, b in above if pose.x < (b[0] - a[0]) * (pose.y - a[1]) / (b[1] - a[1]) + a[0]]
    return len(right) % 2 == 1


def _edges(area: Sequence[Point]) -> Iterable[tuple[Point, Point]]:
    return zip(area, (*area[1:], *area[:1]), strict=True)


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0
