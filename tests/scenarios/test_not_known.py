"""An emergency stop from before, a bumper hit from before: what is not known is said to be not known."""

from __future__ import annotations

import json

import pytest

from woosh_pure import Chassis, GoalFailed, MotionRefused, SimulatedChassis
from woosh_pure.cli.entry import main
from woosh_pure.enums import RobotState
from woosh_pure.reasons import Ready, ReasonKey

pytestmark = pytest.mark.usefixtures("private_config")


@pytest.fixture
def pressed(sim, until):
    """A simulated chassis whose emergency stop was pressed before anybody came."""
    sim.press_emergency_stop()
    until(lambda: not sim.world._reports)
    return sim


def test_a_pressed_emergency_stop_is_no_ready(pressed, woosh, document):
    code, out, _ = woosh("ready", "--listen", "0.2")
    assert code == 5
    assert out.startswith("NOT KNOWN whether it is ready: no /robot_status heard yet")
    code, facts = document("ready", "--listen", "0.2")
    assert (code, facts["ready"], facts["answer"]) == (5, None, "not known")
    assert woosh("ready", "--listen", "0.1", "--wait", "0.3")[0] == 5
    code, out, _ = woosh("faults", "--listen", "0.1")
    assert (code, out.split(":")[0]) == (5, "not known")
    code, facts = document("faults", "--listen", "0.1")
    assert facts == {"known": False, "present": None, "faults": []}


def test_a_robot_that_tells_its_state_gets_a_yes_or_a_no(capsys):
    """A latched /robot_status is told to everybody who comes."""
    with SimulatedChassis(full_graph=False, repeat_status_code=False) as sim:
        words = ["--master", sim.master_uri, "--json"]
        assert main([*words, "ready", "--wait", "5"]) == 0
        assert json.loads(capsys.readouterr().out)["answer"] == "yes"
        assert main([*words, "faults", "--listen", "0.1"]) == 0
        assert json.loads(capsys.readouterr().out) == {"known": True, "present": False, "faults": []}
        sim.press_emergency_stop()
        with Chassis(sim.master_uri) as chassis:
            chassis.status.wait_for(lambda status: status.robot_state is RobotState.FAULT)
        assert main([*words, "ready"]) == 3
        assert json.loads(capsys.readouterr().out)["answer"] == "no"
        assert main([*words, "faults", "--listen", "0.1"]) == 1
        assert json.loads(capsys.readouterr().out) == {"known": False, "present": True, "faults": []}


def test_what_was_refused_is_remembered_until_it_is_over(pressed, until):
    with Chassis(pressed.master_uri) as chassis:
        assert chassis.readiness().answer is Ready.UNKNOWN
        assert chassis.faults.present is None
        with pytest.raises(MotionRefused) as caught:
            chassis.go_to_mark("A1")
        assert caught.value.reasons
        assert ReasonKey.EMERGENCY_STOP in {reason.key for reason in caught.value.reasons} or any(
            reason.key is ReasonKey.REFUSED for reason in caught.value.reasons
        )
        assert chassis.readiness().answer is Ready.NO
        pressed.release_emergency_stop()
        until(lambda: chassis.readiness().answer is Ready.YES)  # it tells that it is idle


def test_a_goal_that_was_refused_is_remembered_without_any_code_heard(pressed, until):
    """The action server's own words name the code."""
    with Chassis(pressed.master_uri) as chassis:
        chassis._components.feeds.get("status_code")._receive = lambda message: None
        with pytest.raises((MotionRefused, GoalFailed)):
            chassis.move(0.1).wait(10.0)
        readiness = chassis.readiness()
        assert readiness.answer is Ready.NO
        assert [r.key for r in readiness.reasons if r.blocking] == [ReasonKey.REFUSED]
        with pytest.raises((MotionRefused, GoalFailed)):
            chassis.move(0.1).wait(10.0)  # the chassis may be asked again
        pressed.release_emergency_stop()
        until(lambda: chassis.readiness().answer is Ready.YES)


def test_a_motion_that_arrives_is_an_answer(sim):
    with Chassis(sim.master_uri) as chassis:
        assert chassis.readiness().answer is Ready.UNKNOWN
        assert chassis.wait_until_ready(1.0).answer is Ready.UNKNOWN
        with pytest.raises(TimeoutError, match="not known"):
            chassis.wait_until_ready(0.1, known=True)
        chassis.move(0.1).wait(10.0)
        assert chassis.readiness().answer is Ready.YES


def test_what_was_told_before_a_broken_link_is_not_known(until):
    """In between it may have changed, and a change is told once."""
    with (
        SimulatedChassis(full_graph=False) as sim,
        Chassis(sim.master_uri) as chassis,
    ):
        assert chassis.readiness().answer is Ready.YES
        sim.crash_node("/ros_interface")
        until(lambda: chassis.readiness().answer is Ready.UNKNOWN)
        assert ReasonKey.LINK_LOST in {reason.key for reason in chassis.readiness().reasons}
        assert chassis.faults.present is None


def test_a_drive_that_was_not_obeyed_is_remembered(pressed, monkeypatch):
    monkeypatch.setattr("woosh_pure.velocity.end_conditions.DISOBEYED_SECONDS", 0.3)
    with Chassis(pressed.master_uri) as chassis:
        with (
            pytest.raises(MotionRefused) as caught,
            chassis.velocity(bypasses_protection=True) as drive,
        ):
            drive.hold(0.1, seconds=20.0)
        assert caught.value.reasons
        readiness = chassis.readiness()
        assert readiness.answer is Ready.UNKNOWN
        assert "the last drive was not obeyed" in readiness.sentence()
        assert not readiness.refuses


def test_a_bumper_that_was_hit_is_a_reason_until_it_is_freed(sim, chassis, until):
    chassis.readiness()
    sim.add_obstacle(0.6, 0.0, 0.2)
    with pytest.raises(GoalFailed):
        chassis.move(1.0, avoid=False).wait(20.0)
    readiness = chassis.readiness()
    assert readiness.answer is Ready.NO
    assert ReasonKey.BUMPER in {reason.key for reason in readiness.reasons}
    assert chassis.faults.present is True
    sim.remove_obstacles()
    sim.release_bumper()
    until(lambda: chassis.readiness().answer is Ready.YES)


def test_a_robot_that_is_not_heard_is_not_said_to_be_ready(until):
    """Its links are up, and nothing comes over them, as with a cable that was pulled."""
    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        until(lambda: chassis.readiness().answer is Ready.YES)
        sim.fall_silent(60.0)
        until(lambda: chassis.readiness().answer is Ready.UNKNOWN)
        assert [reason.key for reason in chassis.readiness().reasons] == [ReasonKey.SILENT]
        assert "nothing was heard from the robot for" in str(chassis.readiness())
        sim.network.restore()
        until(lambda: chassis.readiness().answer is Ready.YES)
