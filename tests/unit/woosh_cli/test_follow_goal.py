"""The line that tells how far a motion is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from woosh_pure.cli.follow_goal import DriveLine
from woosh_pure.geometry import Pose2D
from woosh_pure.motion.progress import length_left

WAY = [Pose2D(0.0, 0.0), Pose2D(4.0, 0.0), Pose2D(4.0, 3.0)]


@pytest.mark.parametrize(
    ("here", "left"),
    [((0.0, 0.0), 7.0), ((1.0, 0.0), 6.0), ((3.0, 0.0), 4.0), ((4.0, 1.0), 2.0), ((4.0, 3.0), 0.0)],
)
def test_what_is_left_of_a_path(here: tuple[float, float], left: float) -> None:
    assert length_left(WAY, Pose2D(*here)) == pytest.approx(left)
    assert length_left([], Pose2D(*here)) is None


class Chassis:
    """Stands for one: a pose."""

    def __init__(self) -> None:
        self.pose: Any = SimpleNamespace(latest=None, open=lambda: None)


def test_distance_and_time_become_known() -> None:
    """Time first; the distance with a pose; the time left when it has come nearer for a while."""
    chassis, now = Chassis(), [100.0]
    line = DriveLine(chassis, Pose2D(10.0, 0.0), clock=lambda: now[0])  # type: ignore[arg-type]
    assert line.text("running") == "0 s   running"
    for second in range(4):
        now[0] = 100.0 + second
        chassis.pose.latest = Pose2D(0.5 * second, 0.0)
        text = line.text("running")
    assert text == "3 s   8.5 m left, about 17 s   at x 1.50 m, y 0.00 m, 0°"


def test_a_robot_that_stands_still_has_no_time_left() -> None:
    chassis, now = Chassis(), [0.0]
    line = DriveLine(chassis, Pose2D(3.0, 4.0), clock=lambda: now[0])  # type: ignore[arg-type]
    chassis.pose.latest = Pose2D(0.0, 0.0)
    for second in range(8):
        now[0] = float(second)
        assert "5.0 m left   at" in line.text("")


def test_steps_tell_their_percent() -> None:
    chassis, now = Chassis(), [0.0]
    line = DriveLine(chassis, clock=lambda: now[0])  # type: ignore[arg-type]
    assert line.text("step 1 of 1: 0 %", 0.0) == "0 s   step 1 of 1: 0 %"
    now[0] = 3.0
    assert line.text("step 1 of 1: 25 %", 25.0) == "3 s   step 1 of 1: 25 %, about 9 s"
