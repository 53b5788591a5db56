"""The simulated chassis seen with ROS's own tools, driven by a rospy program, and on a real rosmaster."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support import ros
from woosh_pure import Chassis, SimulatedChassis, interface


@pytest.fixture
def sim(ros_installed: None) -> Iterator[SimulatedChassis]:
    """The whole graph, in real time times four."""
    with SimulatedChassis(speed=4, assumed_types=True) as simulated:
        yield simulated


def test_rostopic_and_rosnode_see_the_rows_of_the_table(sim: SimulatedChassis, genpy_packages: Path) -> None:
    topics = set(ros.ros_tool(["rostopic", "list"], sim.master_uri).stdout.split())
    expected = {r.name for r in interface.topics()}
    assert expected <= topics
    nodes = set(ros.ros_tool(["rosnode", "list"], sim.master_uri).stdout.split())
    assert {"/ros_interface", "/move_base", "/mobile_base_nodelet_manager"} <= nodes
    info = ros.ros_tool(["rosnode", "info", "/ros_interface"], sim.master_uri).stdout
    assert "/exec_task" in info
    assert "/robot_status [woosh_msgs/RobotStatus]" in info
    assert "TCPROS" in info


def test_rostopic_echoes_the_battery(sim: SimulatedChassis, genpy_packages: Path) -> None:
    echo = ["rostopic", "echo", "-n", "1", "/battery/batteryPercentage"]
    assert "87" in ros.ros_tool(echo, sim.master_uri, packages=genpy_packages).stdout
    kind = ros.ros_tool(["rosservice", "type", "/exec_task"], sim.master_uri, packages=genpy_packages).stdout
    assert kind.strip() == "woosh_msgs/ExecTask"


# What real programs do: call /exec_task, wait for 7 on /robot_status; then a step by actionlib.
PROGRAM = """
import sys, rospy, actionlib
from woosh_msgs.srv import ExecTask, ExecTaskRequest
from woosh_msgs.msg import RobotStatus, StepControlAction, StepControlGoal, StepControl
rospy.init_node("program", disable_signals=True)
states = []
heard = rospy.Subscriber("/robot_status", RobotStatus, lambda m: states.append((m.task_id, m.task_state)))
rospy.wait_for_service("/exec_task", 60)
while not heard.get_num_connections(): rospy.sleep(0.02)
reply = rospy.ServiceProxy("/exec_task", ExecTask)(ExecTaskRequest(task_exect=1, task_id=41, task_type=1, mark_no="P1"))
assert reply.success, reply.message
end = rospy.get_time() + 100
while (41, 7) not in states and rospy.get_time() < end:
    rospy.sleep(0.05)
assert (41, 3) in states and (41, 7) in states, states
client = actionlib.SimpleActionClient("/cmd_vel_control", StepControlAction)
assert client.wait_for_server(rospy.Duration(60))
goal = StepControlGoal(mode=StepControlGoal.EXCUTE, useAvoid=True)
goal.stepControl = [StepControl(executeMode=StepControlGoal.STRAIGHT, data=0.2, speed=0.2)]
client.send_goal_and_wait(goal, rospy.Duration(60))
print("result", client.get_state(), client.get_result().result, client.get_result().percent)
"""


def test_a_rospy_program_drives_the_simulated_chassis(sim: SimulatedChassis, genpy_packages: Path) -> None:
    out = ros.run_rospy(PROGRAM, sim.master_uri, packages=genpy_packages).stdout
    assert "result 3 1 100.0" in out
    assert sim.pose.distance_to(sim.world.site.marks["P1"].pose) == pytest.approx(0.2, abs=0.03)


def test_the_simulated_chassis_joins_a_real_rosmaster(real_roscore: str) -> None:
    with SimulatedChassis(master_uri=real_roscore, speed=8) as sim, Chassis(real_roscore) as chassis:
        chassis.go_to_mark("P1").wait(60)
        chassis.move(0.2).wait()
        assert sim.world.body.distance > 1.0
