"""A `Chassis` of a robot that has only the Robot API, against a robot by script."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosproto import message_class
from rosproto.errors import ConnectionLost, RosError
from tests.support.extras import needs
from tests.support.waiting import until
from woosh_pure import Chassis
from woosh_pure.enums import RobotState
from woosh_pure.errors import MotionRefused
from woosh_pure.outcome import OutcomeKind

needs("api")

from tests.support.scripted_robot import INFO, STANDING, ScriptedRobot  # noqa: E402

MOVING = {**STANDING, "twist": {"linear": 0.2, "angular": 0.0}}


@pytest.fixture
def robot() -> Iterator[ScriptedRobot]:
    with ScriptedRobot() as robot:
        yield robot


@pytest.fixture
def chassis(robot: ScriptedRobot) -> Iterator[Chassis]:
    with Chassis(robot.url) as chassis:
        yield chassis


def info(robot: ScriptedRobot, **sections: Any) -> None:
    robot.answers["RobotInfo"] = lambda _: {**INFO, **sections}


# -- the connection ------------------------------------------------------------------------------------------


def test_nothing_happens_before_the_first_use(robot: ScriptedRobot) -> None:
    chassis = Chassis(robot.url)
    time.sleep(0.2)
    assert robot.connected == 0
    with chassis:
        assert robot.connected == 1
    until(lambda: not robot._peers)


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("ws://user:secret@robot:5480", "robot_api='user:password@host:port'"),
        ("ws://", "host:port"),
        ("ws://robot:port", "host:port"),
        ("ws://robot/path", "host:port"),
    ],
)
def test_a_wrong_address_is_refused_at_once(address: str, said: str) -> None:
    with pytest.raises(ValueError, match=said) as refused:
        Chassis(address)
    assert "secret" not in str(refused.value)


def test_a_host_alone_means_the_usual_port() -> None:
    assert Chassis("ws://robot").master_uri == "ws://robot:5480"


def test_the_environment_names_it_as_any_master(
    robot: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", robot.url)
    with Chassis() as chassis:
        assert chassis.pose.wait(5.0).x == 1.0


def test_nobody_there_is_told_with_address_and_advice() -> None:
    with pytest.raises(ConnectionLost, match=r"127\.0\.0\.1:9.*5480"), Chassis("ws://127.0.0.1:9"):
        pass


@pytest.mark.slow
def test_a_robot_that_does_not_answer_is_told(robot: ScriptedRobot) -> None:
    robot.silent.set()
    with pytest.raises(RosError, match="RobotInfo"), Chassis(robot.url):
        pass


# -- reading -------------------------------------------------------------------------------------------------


def test_what_the_robot_tells_comes_by_the_feeds(chassis: Chassis) -> None:
    assert (chassis.pose.wait(5.0).x, chassis.pose.wait(5.0).yaw) == (1.0, 0.5)
    assert chassis.odometer.wait(5.0) == 42.0
    assert chassis.information.wait(5.0).base_type == "omnidirectional"
    status = chassis.status.wait(5.0, new=False)
    assert (status.task_id, status.robot_state) == (7, RobotState.IDLE)
    assert chassis.readiness().ready


def test_what_it_does_not_tell_is_not_known(chassis: Chassis) -> None:
    battery = chassis.battery.wait(5.0)
    assert battery.percent == 83
    assert math.isnan(battery.voltage)
    assert chassis.localization.wait(5.0).covariance[0, 0] == -1.0


def test_scans_are_subscribed_while_somebody_listens(robot: ScriptedRobot, chassis: Chassis) -> None:
    topic = "woosh.robot.ScannerData"
    assert topic not in robot.topics
    chassis.scan.open()
    until(lambda: topic in robot.topics)

    def scanned() -> bool:
        robot.push("ScannerData", {"ranges": [1.0, 2.0], "rangeMax": 9.0})
        return chassis.scan.latest is not None

    until(scanned)
    chassis.scan.close()
    until(lambda: topic not in robot.topics)


def test_an_emergency_stop_blocks_without_a_code_of_the_robot(robot: ScriptedRobot) -> None:
    info(robot, deviceState={"hardware": 1024, "software": 1})
    with Chassis(robot.url) as chassis:
        until(lambda: chassis.readiness().blocked)
        assert "emergency stop" in chassis.readiness().sentence()
        robot.push("DeviceState", {"hardware": 0, "software": 1})
        until(lambda: not chassis.readiness().blocked)


def test_a_part_that_it_lacks_is_missing_as_with_old_firmware(chassis: Chassis) -> None:
    with pytest.raises(RosError, match="/charge_cmd"):
        chassis.send("/charge_cmd", message_class("woosh_msgs/Charge")(), timeout=0.3)


# -- driving -------------------------------------------------------------------------------------------------


def twists(robot: ScriptedRobot) -> list[Any]:
    return robot.of("Twist")


def drive_for(chassis: Chassis, seconds: float, then: Callable[[], object] = time.monotonic) -> None:
    """Drive for 0.3 s, do something, drive on."""
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.hold(0.2, seconds=0.3)
        then()
        drive.hold(0.2, seconds=seconds)


def test_a_drive_sends_velocities_and_ends_in_zeros(robot: ScriptedRobot, chassis: Chassis) -> None:
    robot.answers["PoseSpeed"] = lambda _: MOVING
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.hold(0.2, seconds=0.5)
    until(lambda: twists(robot)[-3:] == [{}] * 3)
    assert {"linear": 0.2} in [{k: round(v, 3) for k, v in each.items()} for each in twists(robot)]


def test_a_refused_velocity_ends_the_drive_with_the_robots_words(
    robot: ScriptedRobot, chassis: Chassis
) -> None:
    robot.answers["Twist"] = lambda body: "the key switch is in manual" if body else {}
    with pytest.raises(MotionRefused, match="the key switch is in manual"):
        drive_for(chassis, 5.0)
    sent = [each for each in twists(robot) if each]
    time.sleep(0.3)
    assert [each for each in twists(robot) if each] == sent


@pytest.mark.promise("a robot that has only the Robot API answers later than 0.5 s")
def test_a_late_link_ends_the_drive_and_nothing_resumes(robot: ScriptedRobot, chassis: Chassis) -> None:
    robot.answers["PoseSpeed"] = lambda _: MOVING
    with pytest.raises(ConnectionLost):
        drive_for(chassis, 10.0, robot.silent.set)
    silent_at = next(at for at, word, body in robot.asked if word == "Twist" and body) + 0.3
    assert time.monotonic() - silent_at < 3.0
    last = [at for at, word, body in robot.asked if word == "Twist" and body][-1]
    assert last - silent_at < 1.0
    robot.silent.clear()
    robot.asked.clear()
    until(lambda: chassis._bridge is not None and chassis._bridge._good, 10.0)
    assert not [each for each in twists(robot) if each]


def test_a_lost_link_ends_the_drive_and_zero_follows(robot: ScriptedRobot, chassis: Chassis) -> None:
    robot.answers["PoseSpeed"] = lambda _: MOVING

    def cut() -> None:
        robot.drop()
        robot.asked.clear()

    with pytest.raises(ConnectionLost):
        drive_for(chassis, 10.0, cut)
    until(lambda: len(twists(robot)) >= 3, 10.0)
    assert twists(robot)[:3] == [{}] * 3
    assert not [each for each in twists(robot) if each]


def test_a_robot_that_is_not_heard_is_not_said_to_stand(robot: ScriptedRobot, chassis: Chassis) -> None:
    assert chassis.measured_velocity.wait(5.0).is_standing()
    robot.silent.set()
    assert chassis.stop(timeout=1.0).standing is None


# -- tasks ---------------------------------------------------------------------------------------------------


def task_of(robot: ScriptedRobot) -> int:
    until(lambda: robot.of("ExecTask"))
    return int(robot.of("ExecTask")[-1]["taskId"])


def push_task(robot: ScriptedRobot, task_id: int, state: int, robot_state: int = 4) -> None:
    robot.push("TaskProc", {"robotTaskId": str(task_id), "type": 1, "state": state})
    robot.push("RobotState", {"state": robot_state})


def test_a_task_arrives_by_its_own_id_only(robot: ScriptedRobot, chassis: Chassis) -> None:
    goal = chassis.go_to_mark("A1")
    task_id = task_of(robot)
    assert robot.of("ExecTask")[-1]["markNo"] == "A1"
    push_task(robot, task_id + 1, 7)
    assert not goal.done
    push_task(robot, task_id, 3)
    push_task(robot, task_id, 7, 2)
    assert goal.wait(5.0).kind is OutcomeKind.ARRIVED


def test_a_task_goes_on_while_its_link_is_away_and_its_end_is_ours(
    robot: ScriptedRobot, chassis: Chassis
) -> None:
    goal = chassis.go_to_mark("A1")
    task_id = task_of(robot)
    push_task(robot, task_id, 3)
    info(robot, taskProc={"robotTaskId": str(task_id), "state": 3}, state=4)
    robot.drop()
    until(lambda: len(robot.of("RobotInfo")) == 2)
    push_task(robot, task_id + 1, 7)
    assert not goal.done
    until(lambda: (push_task(robot, task_id, 7, 2), goal.done)[1])
    assert goal.wait(5.0).kind is OutcomeKind.ARRIVED
    assert not robot.of("ActionOrder")


@pytest.mark.promise("the connection of a robot that has only the Robot API is lost while a task runs")
def test_a_stop_while_the_link_is_away_cancels_our_task_when_it_is_back(
    robot: ScriptedRobot, chassis: Chassis
) -> None:
    chassis.go_to_mark("A1")
    task_id = task_of(robot)
    push_task(robot, task_id, 3)
    info(robot, taskProc={"robotTaskId": str(task_id), "state": 3}, state=4)
    stopping = threading.Thread(target=chassis.stop)
    robot.answers["ActionOrder"] = lambda _: (push_task(robot, task_id, 8, 2), {})[1]
    robot.drop()
    stopping.start()
    until(lambda: robot.of("ActionOrder"))
    assert robot.of("ActionOrder")[0] == {"order": 4}
    stopping.join(20.0)


def test_a_refused_task_has_the_robots_words(robot: ScriptedRobot, chassis: Chassis) -> None:
    robot.answers["ExecTask"] = lambda _: "there is no mark Q9"
    with pytest.raises(MotionRefused, match="there is no mark Q9"):
        chassis.go_to_mark("Q9")


def test_a_stop_cancels_our_task(robot: ScriptedRobot, chassis: Chassis) -> None:
    goal = chassis.go_to_mark("A1")
    task_id = task_of(robot)
    push_task(robot, task_id, 3)
    robot.answers["ActionOrder"] = lambda _: (push_task(robot, task_id, 8, 2), {})[1]
    report = chassis.stop()
    assert report.standing
    assert robot.of("ActionOrder")[0] == {"order": 4}
    assert goal.outcome is not None
    assert goal.outcome.kind is OutcomeKind.CANCELLED


@pytest.mark.promise("a robot that has only the Robot API carries out another program")
def test_a_strangers_task_is_not_cancelled(robot: ScriptedRobot, chassis: Chassis) -> None:
    goal = chassis.go_to_mark("A1")
    task_id = task_of(robot)
    push_task(robot, task_id, 3)
    until(lambda: (status := chassis.status.latest) is not None and status.task_id == task_id)
    push_task(robot, 99, 3)
    until(lambda: goal.done)
    assert goal.outcome is not None
    assert goal.outcome.kind is OutcomeKind.REPLACED
    chassis.stop()
    assert not robot.of("ActionOrder")


def test_stop_everything_cancels_a_strangers_task_and_goals(robot: ScriptedRobot) -> None:
    info(robot, taskProc={"robotTaskId": "99", "state": 3}, state=4)
    with Chassis(robot.url) as chassis:
        chassis.status.wait(5.0, new=False)
        chassis.stop(everything=True)
        assert {"order": 4} in robot.of("ActionOrder")


@pytest.mark.slow
def test_a_task_whose_request_was_not_answered_is_cancelled_when_it_shows(
    robot: ScriptedRobot, chassis: Chassis
) -> None:
    robot.answers["ExecTask"] = lambda _: (robot.drop(), None)[1]
    with pytest.raises(RosError):
        chassis.go_to_mark("A1")
    task_id = task_of(robot)
    until(lambda: robot._peers)
    until(lambda: (push_task(robot, task_id, 3), robot.of("ActionOrder"))[1])
    assert robot.of("ActionOrder")[0] == {"order": 4}


# -- goals ---------------------------------------------------------------------------------------------------


def feedback(robot: ScriptedRobot, kind: str, state: int, msg: str = "") -> None:
    robot.push(
        "woosh.ros.Feedbacks",
        {"fbs": [{"action": f"woosh.ros.action.{kind}", "state": state, "code": "0", "msg": msg}]},
    )


def begun(robot: ScriptedRobot) -> Any:
    until(lambda: robot.of("CallAction"))
    return robot.of("CallAction")[0]


def test_a_step_is_done_when_the_robot_says_so(robot: ScriptedRobot, chassis: Chassis) -> None:
    goal = chassis.move(0.5)
    body = begun(robot)["stepControl"]
    assert (body["action"], body["steps"][0]["value"]) == (1, 0.5)
    feedback(robot, "StepControl", 2)
    feedback(robot, "MoveBase", -1)  # another kind
    assert not goal.done
    feedback(robot, "StepControl", 1)
    assert goal.wait(5.0).kind is OutcomeKind.ARRIVED


def test_a_failed_goal_has_the_robots_words(robot: ScriptedRobot, chassis: Chassis) -> None:
    goal = chassis.go_to(2.0, 1.0)
    begun(robot)
    feedback(robot, "MoveBase", -1, "no way there")
    until(lambda: goal.done)
    assert goal.outcome is not None
    assert (goal.outcome.kind, "no way there" in str(goal.outcome)) == (OutcomeKind.FAILED, True)


def test_a_cancel_is_sent_and_its_end_awaited(robot: ScriptedRobot, chassis: Chassis) -> None:
    def answer(body: Any) -> dict[str, Any]:
        if not body["moveBase"].get("action"):
            feedback(robot, "MoveBase", -2)
        return {}

    robot.answers["CallAction"] = answer
    goal = chassis.go_to(2.0, 1.0)
    begun(robot)
    goal.cancel()
    until(lambda: goal.done)
    assert goal.outcome is not None
    assert goal.outcome.kind is OutcomeKind.CANCELLED
    assert robot.of("CallAction")[1]["moveBase"] == {}


def test_a_goal_of_which_an_idle_robot_tells_nothing_is_not_said_to_be_done(
    robot: ScriptedRobot, chassis: Chassis
) -> None:
    goal = chassis.move(0.5)
    until(lambda: goal.done, 15.0)
    assert goal.outcome is not None
    assert goal.outcome.kind is OutcomeKind.FAILED


def test_a_step_cannot_be_paused_and_goes_on(robot: ScriptedRobot, chassis: Chassis) -> None:
    robot.answers["PoseSpeed"] = lambda _: MOVING
    goal = chassis.move(0.5)
    begun(robot)
    with pytest.raises(MotionRefused, match="did not confirm the pause"):
        goal.pause()
    assert len(robot.of("CallAction")) == 1
    feedback(robot, "StepControl", 1)
    assert goal.wait(5.0).kind is OutcomeKind.ARRIVED
