"""Clocks that differ: laptops whose clocks are behind or ahead of the robot's drive in turn, and do not shut anybody out."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import pytest

import rosproto
from msgdefs.geometry_msgs.msg import PoseStamped
from rosproto.action import ActionClient, GoalStatus
from rosproto.time import Time
from tests.support.remote import Remote
from woosh_pure import Chassis, Pose2D, SimulatedChassis
from woosh_pure.values.messages import stamped_pose

OFFSETS = (-60.0, 60.0)
TRIALS = 50
LAPTOP = """
import time
wall, wall_ns = time.time, time.time_ns
time.time = lambda: wall() + ({ahead})
time.time_ns = lambda: wall_ns() + round(({ahead}) * 1e9)
from woosh_pure import Chassis
chassis = Chassis({uri!r})
"""


@pytest.fixture
def robot() -> Iterator[SimulatedChassis]:
    """One of its own: the stamp of the last goal stays with the robot."""
    with SimulatedChassis(full_graph=False, speed=8.0) as sim:
        yield sim


def a_laptop(uri: str, ahead: float) -> Remote:
    """A Chassis in a process whose clock is that many seconds ahead."""
    laptop = Remote()
    laptop.do(LAPTOP.format(ahead=ahead, uri=uri))
    return laptop


@pytest.mark.slow
@pytest.mark.promise("this computer's clock differs from the robot's")
def test_laptops_with_clocks_behind_and_ahead_drive_in_turn(robot: SimulatedChassis) -> None:
    """And the robot's own client; each short goal arrives, by each kind of goal."""
    laptops = [a_laptop(robot.master_uri, ahead) for ahead in (*OFFSETS, 0.0)]
    try:
        ends = []
        for trial in range(TRIALS):
            laptop, there = laptops[trial % 3], 0.3 * (trial % 2)
            verb = ("go_to({there}, 0.0)", "move({way})", "go_to({there}, 0.0)")[trial // 3 % 3]
            goal = verb.format(there=there, way=0.05 if trial % 2 else -0.05)
            ends.append(laptop.ask(f"str(chassis.{goal}.wait(30, raises=False).sentence())"))
        assert [end for end in ends if ": arrived" not in end] == []
        assert robot.world.tasks.state.name == "UNDEFINED"
        with Chassis(robot.master_uri) as chassis:
            chassis.go_to_mark("A1").wait(60)  # the robot's own client of /move_base
        assert laptops[0].ask("chassis.go_to(0.0, 0.0).wait(60).arrived") is True
    finally:
        for laptop in laptops:
            laptop.close()


@pytest.mark.slow
@pytest.mark.parametrize("ahead", OFFSETS)
def test_a_robot_whose_clock_differs_is_driven_stopped_and_read(
    robot: SimulatedChassis, ahead: float
) -> None:
    robot.set_clock(ahead)
    with Chassis(robot.master_uri) as chassis:
        assert chassis.pose.wait(5) is not None
        assert chassis.move(0.2).wait(30).arrived
        assert chassis.go_to(0.5, 0.0).wait(30).arrived
        robot.speed = 1.0
        going = chassis.go_to(3.0, 0.0)
        chassis.stop()
        assert going.wait(30, raises=False).kind.name == "CANCELLED"


@pytest.fixture
def asking(robot: SimulatedChassis) -> Iterator[ActionClient]:
    """A client of /move_base, as any program of ROS may be."""
    with (
        rosproto.Node("/program", master_uri=robot.master_uri, host="127.0.0.1") as node,
        ActionClient(node, "/move_base", "woosh_msgs/MoveBaseAction") as client,
    ):
        client.wait_for_server(20)
        yield client


def sent(client: ActionClient, pose: PoseStamped) -> tuple[GoalStatus, str]:
    handle = client.send_goal(client.type.goal(target_pose=pose))
    handle.wait(30)
    return handle.status, handle.text


def a_pose(frame: str = "map", **orientation: float) -> PoseStamped:
    pose: PoseStamped = stamped_pose(Pose2D(0.3, 0.0))
    pose.header.frame_id = frame
    q = pose.pose.orientation
    q.x, q.y, q.z, q.w = (orientation.get(axis, 0.0) for axis in "xyzw")
    return pose


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        (a_pose(), "invalid quaternion"),
        (a_pose(w=1e-4), "invalid quaternion"),
        (a_pose(w=math.nan), "invalid quaternion"),
        (a_pose(x=0.1, w=1.0), "invalid quaternion"),
        (a_pose(y=1.0), "invalid quaternion"),
        (a_pose("", w=1.0), "cannot be empty"),
        (a_pose("/map", w=1.0), "cannot start with a '/'"),
        (a_pose("nowhere", w=1.0), "no transform from nowhere"),
    ],
    ids=["zero", "short", "nan", "tilted", "upside down", "no frame", "slash", "unknown frame"],
)
def test_the_simulated_chassis_refuses_what_noetics_move_base_refuses(
    asking: ActionClient, pose: PoseStamped, why: str
) -> None:
    status, text = sent(asking, pose)
    assert status is GoalStatus.ABORTED
    assert why in text


@pytest.mark.parametrize("pose", [a_pose(w=2.0), a_pose(w=0.5, z=0.1), a_pose(x=0.01, w=1.0)])
def test_it_takes_what_move_base_takes(asking: ActionClient, pose: PoseStamped) -> None:
    """A quaternion that is not normalised, or tilted by little."""
    assert sent(asking, pose)[0] is GoalStatus.SUCCEEDED


@pytest.mark.parametrize(("ahead", "ends"), [(-60, "ABORTED"), (60, "ABORTED"), (0, "SUCCEEDED")])
def test_a_pose_in_another_frame_at_a_time_of_another_clock_is_not_transformed(
    robot: SimulatedChassis, asking: ActionClient, ahead: float, ends: str
) -> None:
    """Our verbs give no time: the newest transform is taken."""
    robot.set_clock(-ahead)
    pose = a_pose("odom", w=1.0)
    with robot.lock:
        pose.header.stamp = Time.from_sec(robot.now + ahead)
    assert sent(asking, pose)[0] is GoalStatus[ends]
    with Chassis(robot.master_uri) as chassis:
        assert chassis.go_to(0.2, 0.0, frame="odom").wait(30).arrived
        assert chassis.go_to(0.0, 0.0, frame="/map").wait(30).arrived
        with pytest.raises(ValueError, match="the pose has no frame"):
            chassis.go_to(0.0, 0.0, frame="")


def test_the_simulated_chassis_replaces_a_goal_stamped_before_the_last_one(
    robot: SimulatedChassis, asking: ActionClient
) -> None:
    """As on a robot; a goal without a stamp is replaced too, until the robot's clock has passed the last goal's."""
    goal = asking.type.action_goal(goal=asking.type.goal(target_pose=a_pose(w=1.0)))
    goal.goal_id.id, goal.goal_id.stamp = "ahead", Time.from_sec(time.time() + 60.0)
    results = rosproto.Node("/results", master_uri=robot.master_uri, host="127.0.0.1")
    with results:
        heard = results.subscriber("/move_base/result", asking.type.action_result, queue_size=10)
        heard.wait_for_connection(timeout=10)
        out = results.publisher("/move_base/goal", asking.type.action_goal)
        out.wait_for_connection(timeout=10)
        out.publish(goal)
        ahead = heard.next(30)
        assert (ahead.status.goal_id.id, ahead.status.status) == ("ahead", GoalStatus.SUCCEEDED)
    assert sent(asking, a_pose(w=1.0))[0] is GoalStatus.RECALLED
    with Chassis(robot.master_uri) as chassis:
        end = chassis.go_to(0.0, 0.0).wait(30, raises=False)
        assert "a program whose clock is ahead of the robot's" in end.sentence()
        robot.set_clock(120.0)
        assert chassis.go_to(0.0, 0.0).wait(30).arrived
