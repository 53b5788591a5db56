"""Debian's `rosnode kill` on a program that drives: the robot stands, and the program is told why."""

from __future__ import annotations

import time

import pytest

from tests.support import ros
from woosh_pure import Chassis, GoalFailed, MotionRefused, SimulatedChassis

pytestmark = pytest.mark.interop


def until_it_stands(sim: SimulatedChassis) -> None:
    end = time.monotonic() + 2.0
    while sim.world.motion is not None or not sim.world.body.velocity.is_standing(0.0, 0.0):
        assert time.monotonic() < end, sim.world.body.velocity
        time.sleep(0.01)


@pytest.mark.parametrize("direct", [False, True], ids=["smooth", "direct"])
def test_a_velocity_ends_in_zero(direct: bool) -> None:
    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        block = chassis.velocity(bypasses_protection=True, direct=direct)
        why = r"shut down \(shutdown by /rosnode.*user request"
        with pytest.raises(MotionRefused, match=why), block as drive:  # noqa: PT012
            drive.set(0.1, valid_for=5.0)
            chassis.measured_velocity.wait_for(lambda v: v.vx > 0.05, 10.0)
            ros.ros_tool(["rosnode", "kill", chassis.node.name], sim.master_uri)
            drive.hold(0.1, seconds=20.0)
        until_it_stands(sim)


def test_a_goal_is_cancelled() -> None:
    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        handle = chassis.go_to_mark("B1")
        chassis.measured_velocity.wait_for(lambda v: v.vx > 0.05, 10.0)
        ros.ros_tool(["rosnode", "kill", chassis.node.name], sim.master_uri)
        with pytest.raises(GoalFailed, match=r"this program ended it: the node was shut down .*/rosnode"):
            handle.wait(20.0)
        until_it_stands(sim)
