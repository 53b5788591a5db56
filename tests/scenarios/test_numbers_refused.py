"""What is not a sensible number is refused with a sentence before anything is sent, whatever type it comes in."""

from __future__ import annotations

import math
from decimal import Decimal

import pytest

from msgdefs.woosh_msgs.msg import MoveBaseGoal
from woosh_pure import Chassis, Footprint, Pose2D
from woosh_pure.motion.steps import Step

HUGE = 10**400
NONSENSE = [HUGE, -HUGE, Decimal("sNaN"), Decimal("Infinity"), math.nan, math.inf, 1e308]
TYPES = [True, "0.5", [0.5], 1j]


@pytest.mark.parametrize("value", [*NONSENSE, *TYPES], ids=repr)
def test_verbs_refuse_them(sim, chassis, value):
    for verb in (
        lambda: chassis.move(value),
        lambda: chassis.move(0.1, speed=value),
        lambda: chassis.rotate(value),
        lambda: chassis.rotate(value, degrees=True),
        lambda: chassis.strafe(value),
        lambda: chassis.move_diagonal(value, 0.0),
        lambda: chassis.move_diagonal(0.1, value),
        lambda: chassis.move_diagonal(0.1, value, degrees=True),
        lambda: chassis.steps(Step.turn(value)),
        lambda: chassis.go_to(value, 0.0),
        lambda: chassis.go_to(0.0, value),
        lambda: chassis.go_to(0.0, 0.0, value),
        lambda: chassis.follow([Pose2D(value, 0.0), Pose2D(1.0, 0.0)]),
        lambda: chassis.task(1, poses=[Pose2D(0.0, value)]),
        lambda: chassis.set_pose(Pose2D(value, 0.0)),
        lambda: chassis.plan(Pose2D(0.0, value)),
        lambda: chassis.set_footprint(Footprint.rectangle(value, 0.5)),
        lambda: chassis.set_footprint([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)], padding=value),
    ):
        with pytest.raises((ValueError, TypeError)) as caught:
            verb()
        assert says_something(caught.value)
    assert sim.world.motion is None
    assert not sim.world.tasks.busy


def says_something(error: Exception) -> bool:
    """A sentence of ours, not what Python says of a conversion that failed."""
    return len(str(error)) > 20 and not any(
        python in str(error)
        for python in ("too large to convert", "cannot convert", "has no attribute", "must be real")
    )


@pytest.mark.parametrize("value", [*NONSENSE, *TYPES], ids=repr)
def test_a_velocity_block_refuses_them_and_stands(sim, chassis, value):
    for option in ("max_linear", "max_angular"):
        with pytest.raises((ValueError, TypeError)):
            chassis.velocity(bypasses_protection=True, **{option: value})
    with chassis.velocity(bypasses_protection=True) as drive:
        for call in (
            lambda: drive.set(value),
            lambda: drive.set(0.0, value),
            lambda: drive.set(0.0, vy=value),
            lambda: drive.set(0.05, valid_for=value),
            lambda: drive.hold(value, seconds=0.1),
        ):
            with pytest.raises((ValueError, TypeError)) as caught:
                call()
            assert says_something(caught.value)
        assert drive.sending.is_standing(0.0, 0.0)
    assert sim.world.body.velocity.is_standing(0.0, 0.0)


@pytest.mark.parametrize("value", [1e308, -1e39, math.nan], ids=repr)
def test_a_goal_message_with_them_is_refused(sim, chassis, value):
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = "map"
    goal.target_pose.pose.position.x = value
    with pytest.raises(ValueError, match="nothing was sent"):
        chassis.action("/move_base", goal)
    assert sim.world.motion is None


@pytest.mark.parametrize("frame", [1.0, None, b"map", ""], ids=repr)
def test_a_frame_is_a_name(sim, chassis, frame):
    with pytest.raises(ValueError, match="frame"):
        chassis.go_to(0.5, 0.0, frame=frame)
    with pytest.raises(ValueError, match=r"frame|in the map"):
        chassis.set_pose(Pose2D(0.5, 0.0, frame=frame))


@pytest.mark.parametrize(
    "timeout", [HUGE, -HUGE, Decimal("sNaN"), math.nan, math.inf, 1e308, True, "5"], ids=repr
)
def test_a_stop_stops_whatever_its_time_limit_is(sim, chassis, until, timeout):
    chassis.move(1.0)
    until(lambda: not sim.world.body.velocity.is_standing())
    assert chassis.stop(timeout=timeout).standing
    assert sim.world.motion is None


@pytest.mark.parametrize("value", [Decimal("0.05"), 0.05], ids=repr)
def test_the_simulation_takes_a_decimal_and_goes_on(sim, chassis, value):
    try:
        sim.slow_network(value)
        assert chassis.measured_velocity.wait(5.0) is not None
    finally:
        sim.slow_network(0.0)
    for nonsense in (HUGE, math.nan, -1.0, True, Decimal("sNaN")):
        for call in (sim.slow_network, sim.fall_silent, sim.drop_link):
            with pytest.raises((ValueError, TypeError)):
                call(nonsense)
    assert chassis.measured_velocity.wait(5.0) is not None


def test_a_cancel_and_a_chassis_take_the_largest_time_limit_there_is(sim):
    with Chassis(sim.master_uri, timeout=1e308) as chassis:
        assert not chassis.move(1.0).cancel(1e308).arrived
