"""Poses, velocities and footprints as plain values: SI units, REP 103 axes (x forward, y left, yaw
counter-clockwise)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto import quaternion
from rosproto.coercion import as_float
from rosproto.deprecation import former_names
from rosproto.sentence import say
from woosh_pure.hints import POSE, Hints, refusing

__all__ = [
    "MAX_COORDINATE_METRES",
    "Footprint",
    "Pose2D",
    "Velocity",
    "normalize_angle",
    "quaternion_from_yaw",
    "yaw_from_quaternion",
]


def normalize_angle(angle: float) -> float:
    """The same direction in (-pi, pi].

    Raises:
        ValueError: `angle` is not finite.
    """
    if not math.isfinite(angle):
        raise ValueError(say("angle {angle} is not finite; give radians as a number", angle=angle))
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def quaternion_from_yaw(yaw: float) -> tuple[float, float, float, float]:
    """(x, y, z, w) of a rotation by `yaw` rad about z."""
    return quaternion.from_yaw(yaw)


def yaw_from_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Yaw in rad of a quaternion (ZYX order, as tf does); an all-zero quaternion counts as no rotation."""
    return quaternion.yaw_of((x, y, z, w))


MAX_COORDINATE_METRES = 100_000.0
"""No map is as large, so a larger number is invalid, or in another unit."""
__getattr__ = former_names(__name__, {"FARTHEST": "MAX_COORDINATE_METRES"})


def _as_floats(value: object, *names: str) -> None:
    """Convert the numbers of a frozen value to float: small numpy types overflow and lose digits in sums."""
    for name in names:
        number = getattr(value, name)
        if type(number) is not float:
            object.__setattr__(value, name, as_float(number))


@dataclass(frozen=True, slots=True)
class Pose2D(Hints):
    """A pose in the plane: `frame`_T_`child`.

    Attributes:
        x, y: Metres, in `frame`.
        yaw: Radians, counter-clockwise positive, (-pi, pi] when made by this library.
        frame: The reference frame.
        child: The located frame.
    """

    _hints = POSE

    x: float
    y: float
    yaw: float = 0.0
    frame: str = "map"
    child: str = "base_link"

    if not TYPE_CHECKING:
        __getitem__ = refusing("{kind!r} object is not subscriptable; use x, y and yaw")

    def __post_init__(self) -> None:
        _as_floats(self, "x", "y", "yaw")
        if not isinstance(self.frame, str):
            raise ValueError(say('frame {frame!r}: give its name as text, such as "map"', frame=self.frame))

    @property
    def yaw_degrees(self) -> float:
        """Yaw in degrees, for people."""
        return math.degrees(self.yaw)

    def require_finite(self) -> Pose2D:
        """This pose, checked.

        Raises:
            ValueError: A number is NaN or infinite.
        """
        if not all(map(math.isfinite, (self.x, self.y, self.yaw))):
            wrong = "pose {x}, {y}, {yaw}: every number must be finite (m, m, rad)"
            raise ValueError(say(wrong, x=self.x, y=self.y, yaw=self.yaw))
        return self

    def require_sensible(self) -> Pose2D:
        """This pose, checked as the target of a command.

        Raises:
            ValueError: A number is NaN or infinite, the yaw is more than one turn (degrees?), or there is no
                frame; or it is farther than any map reaches.
        """
        self.require_finite()
        if max(abs(self.x), abs(self.y)) > MAX_COORDINATE_METRES:
            wrong = "pose {x:g}, {y:g}: more than {farthest:g} m away; give metres"
            raise ValueError(say(wrong, x=self.x, y=self.y, farthest=MAX_COORDINATE_METRES))
        if abs(self.yaw) > 2.0 * math.pi + 1e-6:
            wrong = "yaw {yaw:g} rad is more than one turn; for degrees give math.radians({yaw:g})"
            raise ValueError(say(wrong, yaw=self.yaw))
        if not self.frame.strip("/ "):
            raise ValueError('the pose has no frame; "map" is the chassis\'s own map')
        return self

    def distance_to(self, other: Pose2D) -> float:
        """Straight distance in m; both poses must be in one frame."""
        if self.frame.lstrip("/") != other.frame.lstrip("/"):
            wrong = "poses in {frame} and {other} cannot be compared; transform one of them first"
            raise ValueError(say(wrong, frame=self.frame, other=other.frame))
        return math.hypot(other.x - self.x, other.y - self.y)

    def angle_to(self, other: Pose2D) -> float:
        """Turn from this heading to the other's in rad, the short way."""
        return normalize_angle(other.yaw - self.yaw)

    def transformed(self, forward: float, left: float, turn: float) -> Pose2D:
        """The pose after moving in its own axes by (forward, left) m and then turning by `turn` rad."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return Pose2D(
            self.x + c * forward - s * left,
            self.y + s * forward + c * left,
            normalize_angle(self.yaw + turn),
            self.frame,
            self.child,
        )

    def __str__(self) -> str:
        return say(
            "x {x:.3f} m, y {y:.3f} m, yaw {yaw:.1f}° in {frame}",
            x=self.x,
            y=self.y,
            yaw=self.yaw_degrees,
            frame=self.frame,
        )


@dataclass(frozen=True, slots=True)
class Velocity:
    """A body velocity in base_link.

    Attributes:
        vx, vy: m/s, forward and left positive.
        wz: rad/s, counter-clockwise positive.
    """

    vx: float = 0.0
    vy: float = 0.0
    wz: float = 0.0

    def __post_init__(self) -> None:
        _as_floats(self, "vx", "vy", "wz")

    def is_standing(self, linear: float = 0.01, angular: float = 0.01) -> bool:
        """True when both speeds are at most the given m/s and rad/s."""
        return math.hypot(self.vx, self.vy) <= linear and abs(self.wz) <= angular


@dataclass(frozen=True, slots=True)
class Footprint:
    """The outline of the robot in base_link: a simple polygon around the origin.

    Attributes:
        points: Corners (x, y) in m, in order; not closed (the last joins the first).
    """

    points: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        _check_polygon(self.points)

    @classmethod
    def from_points(cls, points: Iterable[Sequence[float]], padding: float = 0.0) -> Footprint:
        """From corners in m, moved outwards by `padding` m as costmap_2d's footprint_padding does.

        Raises:
            ValueError: Not a simple polygon around the origin, not in metres, or `padding` is negative.
        """
        padding = as_float(padding)
        if not (math.isfinite(padding) and padding >= 0.0):
            raise ValueError(say("padding={padding}: must be a number of at least 0 (m)", padding=padding))
        try:
            corners = [(as_float(x), as_float(y)) for x, y in points]
        except (TypeError, ValueError):
            raise ValueError("a footprint is made of corners (x, y), two numbers in m each") from None
        return cls(tuple((_padded(x, padding), _padded(y, padding)) for x, y in corners))

    @classmethod
    def rectangle(cls, length: float, width: float, padding: float = 0.0) -> Footprint:
        """A box of `length` (x) by `width` (y) m, centred on base_link."""
        length, width = _positive(length=length, width=width)
        x, y = length / 2.0, width / 2.0
        return cls.from_points(((x, y), (-x, y), (-x, -y), (x, -y)), padding)

    @classmethod
    def circle(cls, radius: float, padding: float = 0.0, corners: int = 16) -> Footprint:
        """A regular polygon through a circle of `radius` + `padding` m."""
        (radius,) = _positive(radius=radius)
        if corners < 3:
            raise ValueError(say("corners={corners}: a circle needs at least 3", corners=corners))
        r = radius + as_float(padding)
        steps = (2.0 * math.pi * k / corners for k in range(corners))
        return cls(tuple((r * math.cos(a), r * math.sin(a)) for a in steps))

    @property
    def circumscribed_radius(self) -> float:
        """Distance in m of the farthest corner."""
        return max(math.hypot(x, y) for x, y in self.points)

    @property
    def inscribed_radius(self) -> float:
        """Distance in m of the nearest edge from the origin."""
        pairs = zip(self.points, self.points[1:] + self.points[:1], strict=True)
        return min(_distance_to_segment(a, b) for a, b in pairs)


_MAX_CORNER_METRES = 10.0  # m; no loaded chassis is larger, so larger numbers are in another unit


def _padded(value: float, padding: float) -> float:
    return value + math.copysign(padding, value) if value else value


def _positive(**values: float) -> list[float]:
    numbers = [as_float(value) for value in values.values()]
    for name, number in zip(values, numbers, strict=True):
        if not (math.isfinite(number) and number > 0.0):
            raise ValueError(
                say("{name}={number}: must be a positive number of metres", name=name, number=number)
            )
    return numbers


def _check_polygon(points: Sequence[tuple[float, float]]) -> None:
    if len(points) < 3:
        raise ValueError(say("a footprint needs at least 3 corners, got {count}", count=len(points)))
    for x, y in points:
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError(say("footprint corner ({x}, {y}): both numbers must be finite (m)", x=x, y=y))
        if math.hypot(x, y) > _MAX_CORNER_METRES:
            wrong = "footprint corner ({x}, {y}) is more than {maximum:g} m away; give metres"
            raise ValueError(say(wrong, x=x, y=y, maximum=_MAX_CORNER_METRES))
    edges = list(zip(points, (*points[1:], points[0]), strict=True))
    for i, (a, b) in enumerate(edges):
        if a == b:
            wrong = "footprint corners {i} and {j} are the same point {a}; remove one"
            raise ValueError(say(wrong, i=i, j=(i + 1) % len(points), a=a))
        for j in range(i + 2, len(edges)):
            if (j + 1) % len(edges) != i and _segments_cross(a, b, *edges[j]):
                wrong = "footprint edges {i} and {j} cross; give the corners in order around the robot"
                raise ValueError(say(wrong, i=i, j=j))
    if not _contains_origin(edges):
        raise ValueError(
            "the footprint does not contain base_link (0, 0); the corners are relative to the robot's centre"
        )


def _cross(o: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def _segments_cross(
    a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], d: tuple[float, float]
) -> bool:
    return (_cross(a, b, c) > 0) != (_cross(a, b, d) > 0) and (_cross(c, d, a) > 0) != (_cross(c, d, b) > 0)


def _contains_origin(edges: Sequence[tuple[tuple[float, float], tuple[float, float]]]) -> bool:
    inside = False
    for (ax, ay), (bx, by) in edges:
        # The edge crosses the positive x axis: an odd number of crossings means inside.
        if (ay > 0) != (by > 0) and ax + (bx - ax) * (-ay) / (by - ay) > 0:
            inside = not inside
    return inside


def _distance_to_segment(a: tuple[float, float], b: tuple[float, float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    # Share of the segment at which it is nearest to the origin.
    t = min(1.0, max(0.0, -(a[0] * dx + a[1] * dy) / (dx * dx + dy * dy)))
    return math.hypot(a[0] + t * dx, a[1] + t * dy)
