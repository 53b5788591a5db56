"""The limits of an assistant's motions, without a robot."""

from __future__ import annotations

import math
import random

import pytest

from woosh_pure.geometry import Pose2D
from woosh_pure.mcp.limits import Limits, area_of, contains

HALL = ((-1.0, -1.0), (4.0, -1.0), (4.0, 3.0), (2.0, 3.0), (2.0, 1.0), (-1.0, 1.0))
"""An L: what is left of x 2 m ends at y 1 m."""


def in_hall(x: float, y: float) -> bool:
    """The same by comparing numbers."""
    return (-1.0 < x < 4.0 and -1.0 < y < 1.0) or (2.0 < x < 4.0 and -1.0 < y < 3.0)


def test_none_of_1000_random_goals_outside_is_accepted() -> None:
    """What is accepted is inside the area and near enough; what is refused is not."""
    draw, limits = random.Random(45), Limits(area=HALL, max_distance=2.5)
    accepted = 0
    for _ in range(1000):
        here = Pose2D(draw.uniform(-0.9, 3.9), draw.uniform(-0.9, 0.9))
        target = Pose2D(draw.uniform(-4.0, 7.0), draw.uniform(-4.0, 6.0))
        allowed = in_hall(target.x, target.y) and here.distance_to(target) <= 2.5
        assert (limits.refusal(here, target) == "") == allowed, (here, target)
        accepted += allowed
    assert 50 < accepted < 950


def test_a_straight_way_must_not_cut_a_corner() -> None:
    """Both ends are inside, and the way between them is not: refused where the robot would drive straight."""
    limits, draw = Limits(area=HALL), random.Random(7)
    here, target = Pose2D(-0.5, 0.9), Pose2D(2.5, 2.8)
    assert limits.refusal(here, target) == ""
    assert "way" in limits.refusal(here, target, straight=True)
    for _ in range(1000):
        a, b = (Pose2D(draw.uniform(-0.99, 3.99), draw.uniform(-0.99, 2.99)) for _ in range(2))
        if limits.refusal(a, b, straight=True) == "":
            way = [
                (a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
                for share in (i / 50 for i in range(51))
            ]
            assert all(in_hall(x, y) for x, y in way), (a, b)


def test_a_pose_or_a_path_that_leaves_is_seen() -> None:
    limits, start = Limits(area=HALL, max_distance=3.0), Pose2D(0.0, 0.0)
    assert limits.leaves(start, [Pose2D(0.0, 0.0), Pose2D(1.0, 0.5)]) == ""
    assert "outside" in limits.leaves(start, [Pose2D(1.0, 0.5), Pose2D(1.0, 1.2), Pose2D(2.5, 0.5)])
    assert "3.05 m" not in limits.leaves(start, [Pose2D(3.05, 0.0)]), (
        "a measured pose may be a little farther"
    )
    assert "3.20 m" in limits.leaves(start, [Pose2D(3.2, 0.0)])


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_place_is_refused(value: float) -> None:
    limits = Limits(max_distance=3.0)
    assert limits.leaves(Pose2D(0.0, 0.0), [Pose2D(value, 0.0)])
    assert limits.refusal(Pose2D(0.0, 0.0), Pose2D(0.0, value))
    assert "map" in limits.leaves(Pose2D(0.0, 0.0), [Pose2D(0.0, 0.0, 0.0, "odom")])


def test_without_a_place_limits_of_place_refuse() -> None:
    assert "where the robot is" in Limits(max_distance=1.0).refusal(None, Pose2D(0.0, 0.0))
    assert "target" in Limits(area=HALL).refusal(Pose2D(0.0, 0.0), None)
    assert Limits(max_speed=0.5).refusal(None, None) == ""


@pytest.mark.parametrize(
    "wrong",
    [
        {"max_distance": 0.0},
        {"max_distance": math.inf},
        {"max_speed": -1.0},
        {"max_speed": 50.0},
        {"max_seconds": math.nan},
        {"max_seconds": 1e6},
        {"area": ((0.0, 0.0), (1.0, 0.0))},
        {"area": ((0.0, 0.0), (1.0, 0.0), (math.nan, 1.0))},
    ],
)
def test_limits_that_make_no_sense_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError):
        Limits(**wrong)  # type: ignore[arg-type]


def test_an_area_file_has_a_corner_a_line() -> None:
    assert area_of("# the hall\n0,0\n4, 0  # a corner\n\n4 3\n0,3\n") == ((0, 0), (4, 0), (4, 3), (0, 3))
    assert contains(area_of("0,0\n4,0\n4,3\n0,3"), Pose2D(2.0, 1.0))
    for wrong in (
        "",
        "# nothing",
        "0,0\n1,0",
        "0,0\n1\n2,2",
        "0,0,0\n1,1,1\n2,2,2",
        "a,b\n1,1\n2,2",
        "nan,0\n1,1\n2,2",
    ):
        with pytest.raises(ValueError, match="area"):
            area_of(wrong)
