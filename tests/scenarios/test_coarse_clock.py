"""Windows' clocks go in steps of 15.6 ms (CPython before 3.13): nothing may spin, lapse early or come twice by it."""

from __future__ import annotations

import time

import pytest

from rosproto import Node, RosTimeout
from woosh_pure import Chassis, SimulatedChassis

STEP = 0.015625


@pytest.fixture
def coarse(monkeypatch) -> None:
    """The clocks of this process in Windows' steps."""
    monotonic, wall = time.monotonic, time.time
    monkeypatch.setattr(time, "monotonic", lambda: monotonic() // STEP * STEP)
    monkeypatch.setattr(time, "time", lambda: wall() // STEP * STEP)


def test_a_robot_is_driven_by_clocks_that_go_in_steps(coarse) -> None:
    """A step, a velocity at a steady rate, its lapse, and a time-out that is not early."""
    assert time.monotonic() % STEP == 0.0
    sent: list[tuple[float, float]] = []
    with (
        SimulatedChassis(full_graph=False, speed=4) as sim,
        Chassis(sim.master_uri) as chassis,
        Node("/spy", master_uri=sim.master_uri, rosout=False) as spy,
        spy.subscriber(
            "/base_cmd_vel", "geometry_msgs/Twist", lambda m: sent.append((time.perf_counter(), m.linear.x))
        ),
    ):
        chassis.move(0.2).wait(timeout=10.0)
        assert sim.pose.x == pytest.approx(0.2, abs=0.02)
        with chassis.velocity(bypasses_protection=True, direct=True) as drive:
            drive.set(0.1, valid_for=1.5)
            chassis.measured_velocity.wait_for(lambda v: v.vx > 0.05, 5.0)
            chassis.measured_velocity.wait_for(lambda v: v.is_standing(), 10.0)  # lapsed by itself
        began = time.perf_counter()
        with pytest.raises(RosTimeout), spy.subscriber("/nobody", "std_msgs/Empty") as silent:
            silent.next(timeout=0.2)
        assert time.perf_counter() - began >= 0.2 - STEP
    moving = [at for at, vx in sent if vx > 0.0]
    assert len(moving) >= 3
    assert 0.2 < moving[-1] - moving[0] < 10.0  # it was told once, for 1.5 s
    assert len(moving) / (moving[-1] - moving[0]) < 100.0  # steady, not as fast as it can
