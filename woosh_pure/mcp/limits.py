"""Where and how an assistant may move the robot. Pure: it judges a target before, and poses and paths on the way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.motion.steps import MAX_SPEED

MAX_MOTION_SECONDS = 3600.0
DISTANCE_SLACK, SPEED_SLACK = 0.1, 0.05
"""m and m/s by which the measured place and speed of a drive may exceed the limits."""
Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of each motion; they are kept by the server, whatever a client asks for.

    Attributes:
        only_marks: Only drives to known marks; no poses, steps or turns.
        area: Corners of the only area that may be driven in, m in the map; () for no such limit. It is judged
            by the robot's centre.
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
        for name, value, most in (
            ("max_distance", self.max_distance, math.inf),
            ("max_speed", self.max_speed, MAX_SPEED),
            ("max_seconds", self.max_seconds, MAX_MOTION_SECONDS),
        ):
            if value is not None and not (math.isfinite(value) and 0.0 < value <= most):
                wrong = "{name}={value:g}: expected more than 0, and at most {most:g}"
                raise ValueError(say(wrong, name=name, value=value, most=most))
        if self.area and (
            len(self.area) < 3 or not all(math.isfinite(v) for point in self.area for v in point)
        ):
            raise ValueError("the area needs at least three corners, each of two finite numbers in m")

    @property
    def by_place(self) -> bool:
        """Whether the place of the robot must be known."""
        return bool(self.area) or self.max_distance is not None

    def refusal(self, here: Pose2D | None, target: Pose2D | None, *, straight: bool = False) -> str:
        """Why a motion from here to a target is refused; "" if it is not.

        Args:
            here: Where the robot is, in the map; None if that is not known.
            target: Where it would be at the end; None if that is not known.
            straight: Whether it would go there in a straight line.
        """
        if not self.by_place:
            return ""
        if here is None:
            return "where the robot is in its map is not known now, so the limits cannot be kept"
        if target is None:
            return "the place of the target is not known, so the limits cannot be kept"
        if not target.frame.lstrip("/") == here.frame.lstrip("/") == "map":
            return "the limits need poses in the map"
        return self.leaves(here, [here, target], straight=straight, slack=0.0)

    def leaves(
        self, start: Pose2D, way: Sequence[Pose2D], *, straight: bool = False, slack: float = DISTANCE_SLACK
    ) -> str:
        """Why a way (one pose: where the robot is) breaks the limits; "" if it does not.

        Args:
            start: Where the motion began.
            way: Poses in the map.
            straight: Whether the lines between the poses count, too.
            slack: m that it may be farther away, for measured poses.
        """
        for pose in way:
            if not (math.isfinite(pose.x) and math.isfinite(pose.y)):
                return "a pose is not a number, so the limits cannot be kept"
            if self.max_distance is not None and (far := start.distance_to(pose)) > self.max_distance + slack:
                wrong = "{far:.2f} m from where it began; at most {most:g} m are allowed"
                return say(wrong, far=far, most=self.max_distance)
            if self.area and not contains(self.area, (pose.x, pose.y)):
                return say("x {x:.2f} m, y {y:.2f} m is outside the allowed area", x=pose.x, y=pose.y)
        if straight and self.area:
            for a, b in pairwise((pose.x, pose.y) for pose in way):
                if any(_cross(a, b, *edge) for edge in edges(self.area)):
                    return "the straight way leaves the allowed area"
        return ""

    def speed(self, wanted: float, default: float) -> float:
        """The speed to send, m/s, for one that is wanted (0: the robot's own, `default`).

        Raises:
            ValueError: It is above the limit.
        """
        if self.max_speed is None:
            return wanted
        if wanted > self.max_speed:
            wrong = "{wanted:g} m/s is faster than the {most:g} m/s that are allowed"
            raise ValueError(say(wrong, wanted=wanted, most=self.max_speed))
        return wanted or min(default, self.max_speed)

    def too_fast(self, measured: float) -> bool:
        """Whether a measured speed, m/s, is above the limit."""
        return self.max_speed is not None and abs(measured) > self.max_speed + SPEED_SLACK


def area_of(text: str) -> tuple[Point, ...]:
    """The corners of an area file: a line `X,Y` for each, m in the map; `#` begins a comment.

    Raises:
        ValueError: It is not such a file.
    """
    found: list[Point] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            x, y = map(float, words)
        except ValueError:
            wrong = "line {number}: expected X,Y in metres, such as 1.5,-2"
            raise ValueError(say(wrong, number=number)) from None
        found.append((x, y))
    if len(found) < 3:
        raise ValueError("an area needs at least three corners, a line X,Y for each")
    return Limits(area=tuple(found)).area


def edges(area: Sequence[Point]) -> Iterable[tuple[Point, Point]]:
    """The edges of a polygon."""
    return zip(area, (*area[1:], area[0]), strict=True)


def contains(area: Sequence[Point], point: Point) -> bool:
    """Whether a point is inside a polygon (even-odd rule)."""
    x, y = point
    inside = False
    for (ax, ay), (bx, by) in edges(area):
        if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
            inside = not inside
    return inside


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0
