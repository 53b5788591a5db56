"""`Chassis` against a chassis made of rospy nodes: another implementation of the wire plays the robot."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto.errors import RosTimeout
from rosproto.master import Master
from rosproto.node import MasterClient
from tests.support import ros
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind

# Marks say what the rospy chassis does with the task; the velocity it was given last comes back on /odom_twist.
ROBOT = """
import threading, rospy, actionlib
from geometry_msgs.msg import Twist, Pose2D
from std_msgs.msg import UInt64
from woosh_msgs.msg import (Battery, RobotStatus, StepControlAction, StepControlResult, StepControlFeedback,
    MoveBaseAction, MoveBaseResult)
from woosh_msgs.srv import ExecTask, ExecTaskResponse
rospy.init_node("ros_interface", disable_signals=True)
status = rospy.Publisher("/robot_status", RobotStatus, queue_size=10, latch=True)
battery = rospy.Publisher("/battery", Battery, queue_size=10)
pose = rospy.Publisher("/movebase_pose2d", Pose2D, queue_size=10)
measured = rospy.Publisher("/odom_twist", Twist, queue_size=10)
last = [Twist()]
def obey(m): last[0] = m
rospy.Subscriber("/smooth_cmd_vel", Twist, obey)
rospy.Subscriber("/base_cmd_vel", Twist, obey)
def say(task_id, state): status.publish(RobotStatus(task_id=task_id, task_state=state, robot_state=4, robot_mode=1, work_mode=2))
def exec_task(r):
    if r.task_exect == 4:
        say(r.task_id, 8); return ExecTaskResponse(True, "", 2)
    if r.mark_no == "refused": return ExecTaskResponse(False, "other task running", 4)
    say(r.task_id, 3)
    end = {"A": 7, "fails": 9}.get(r.mark_no)
    if r.mark_no == "early":
        say(r.task_id, 7); rospy.sleep(0.5)
    elif end: threading.Timer(0.3, say, (r.task_id, end)).start()
    return ExecTaskResponse(True, "", 4)
rospy.Service("/exec_task", ExecTask, exec_task)
def step(goal):
    for percent in (30.0, 60.0, 100.0):
        steps.publish_feedback(StepControlFeedback(executeMode=1, percent=percent))
        while rospy.get_param("/percent", 100.0) < percent: rospy.sleep(0.01)
        if steps.is_preempt_requested(): steps.set_preempted(StepControlResult(result=-1)); return
    good = goal.stepControl[0].data > 0
    steps.set_succeeded(StepControlResult(result=1 if good else -3, executeMode=1, percent=100.0))
steps = actionlib.SimpleActionServer("/cmd_vel_control", StepControlAction, step, auto_start=False); steps.start()
def go(goal):
    while not base.is_preempt_requested():
        rospy.sleep(0.05)
        if goal.target_pose.pose.position.x < 5: base.set_succeeded(MoveBaseResult()); return
    base.set_preempted(MoveBaseResult())
base = actionlib.SimpleActionServer("/move_base", MoveBaseAction, go, auto_start=False); base.start()
say(1, 7)
print("up", flush=True)
try:
    while not rospy.is_shutdown():
        battery.publish(Battery(batteryPercentage=55, batteryVoltage=25.0)); pose.publish(Pose2D(1.0, 2.0, 0.5))
        measured.publish(last[0]); rospy.sleep(0.05)
finally: rospy.signal_shutdown("interrupted")  # which the threads of the actions wait for
"""


@pytest.fixture(scope="module")
def master() -> Iterator[Master]:
    """The master of the rospy robot: ours."""
    with Master() as master:
        yield master


@pytest.fixture(scope="module")
def robot(master: Master, genpy_packages: Path) -> Iterator[Chassis]:
    """A Chassis connected to the rospy robot; one for the whole file."""
    with ros.start_rospy(ROBOT, master.uri, packages=genpy_packages) as process:
        process.wait_for("up", 60.0)
        with Chassis(master.uri, timeout=20.0) as chassis:
            yield chassis


def outcome(handle: Any, timeout: float = 20.0) -> OutcomeKind:
    kind: OutcomeKind = handle.wait(timeout, raises=False).kind
    return kind


def test_reading(robot: Chassis) -> None:
    assert robot.battery.wait(10.0).percent == 55
    assert (robot.pose.wait(10.0).x, robot.pose.wait(10.0).yaw) == (1.0, 0.5)


def test_tasks_end_as_they_should(robot: Chassis) -> None:
    assert robot.status.wait(10.0, new=False).task_state == 7  # the stale completion of somebody else's task
    assert outcome(robot.go_to_mark("A")) is OutcomeKind.ARRIVED
    assert outcome(robot.go_to_mark("early")) is OutcomeKind.ARRIVED
    assert outcome(robot.go_to_mark("fails")) is OutcomeKind.FAILED
    with pytest.raises(MotionRefused, match="other task running"):
        robot.go_to_mark("refused")
    assert outcome(robot.go_to_mark("never ends"), 0.5) is OutcomeKind.TIMED_OUT


def test_steps_and_navigation_end_as_they_should(robot: Chassis, master: Master) -> None:
    # The result is another topic than the feedback, and may overtake it: the robot waits until that has been seen.
    with MasterClient(master.uri, "/test") as parameters:
        parameters.set_param("/percent", 0.0)
        handle = robot.move(0.5)
        seen = []
        for report in handle.reports():
            seen.append(report.percent)
            parameters.set_param("/percent", report.percent)
    assert seen == [30.0, 60.0, 100.0]
    assert handle.wait(10.0).code == 1
    with pytest.raises(GoalFailed) as caught:
        robot.move(-0.5).wait(10.0)  # actionlib says succeeded, the result is -3
    assert caught.value.outcome.code == -3
    assert outcome(robot.go_to(1.0, 0.0)) is OutcomeKind.ARRIVED
    assert outcome(robot.go_to(9.0, 0.0), 0.5) is OutcomeKind.TIMED_OUT


def test_velocity_ends_in_zero(robot: Chassis) -> None:
    with robot.velocity(bypasses_protection=True, feedback_timeout=10.0) as drive:
        drive.set(0.2, valid_for=5.0)
        robot.measured_velocity.wait_for(lambda v: v.vx > 0.15, 5.0)
    robot.measured_velocity.wait_for(lambda v: v.is_standing(0.0, 0.0), 5.0)
    time.sleep(0.2)
    with pytest.raises(RosTimeout):
        robot.measured_velocity.wait_for(lambda v: v.vx != 0.0, 0.3)
