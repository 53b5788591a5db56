"""What objects say of themselves in an interactive interpreter."""

from __future__ import annotations

from typing import Any, cast

from woosh_pure import Chassis, MotionRefused, SimulatedChassis
from woosh_pure.reasons import Readiness, Reason
from woosh_pure.velocity.drive import Drive
from woosh_pure.velocity.shaper import DriveLimits


def test_a_chassis_says_whether_it_is_connected_and_what_runs():
    chassis = Chassis("127.0.0.1:9")
    assert repr(chassis) == "<Chassis http://127.0.0.1:9/, not connected yet: nothing under way>"
    chassis.close()
    assert repr(chassis) == "<Chassis http://127.0.0.1:9/, closed: nothing under way>"


def test_a_drive_says_whether_it_was_entered_and_what_it_sends():
    drive = Drive(cast(Any, None), "/smooth_cmd_vel", DriveLimits(), 1.0, since=0)
    assert repr(drive) == "<Drive /smooth_cmd_vel, not entered: 0 0 m/s, 0 rad/s>"


def test_a_simulated_chassis_says_where_it_is():
    sim = SimulatedChassis()
    assert repr(sim) == "<SimulatedChassis, not started>"
    with sim:
        assert repr(sim).startswith(
            f"<SimulatedChassis {sim.master_uri}, 1 times real time, idle, at x 0.000 m"
        )
    assert ", closed, at" in repr(sim)


def test_a_refusal_gives_reasons_and_not_what_is_unknown():
    known = Reason("other_client", "task 5 of another client is running", blocking=False)
    unknown = Reason("unknown", "no /robot_status heard yet", blocking=False)
    assert str(MotionRefused("refused", readiness=Readiness((unknown, known)))) == f"refused; {known.text}"
