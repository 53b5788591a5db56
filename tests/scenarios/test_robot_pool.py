"""What a test gets from the pool is as good as new, whatever the one before it left under way."""

from __future__ import annotations

from tests.support.robot_pool import RobotPool
from woosh_pure import Chassis


def test_what_a_slow_network_still_carried_does_not_reach_the_next_test(until) -> None:
    """An emergency stop is pressed behind a slow network, which is quick again when the test ends."""
    with RobotPool(full_graph=False) as pool:
        robot = pool.take(8.0)
        sim = robot.sim
        with Chassis(sim.master_uri) as chassis:
            chassis.status.connect()
            sim.slow_network(1.0)
            sim.press_emergency_stop()
            until(lambda: sim.network._queue, what="a message under way")
            sim.slow_network(0.0)
        pool.give_back(robot)
        sim = pool.take(8.0).sim  # the same, unless what was under way took too long
        assert not sim.network._queue
        assert not sim.world.emergency_stop
        with Chassis(sim.master_uri) as chassis:
            assert chassis.wait_until_ready(20.0).answer
