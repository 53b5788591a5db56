"""What the simulated chassis does as a real graph does: its own client, its network, frames, odd types."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from contextlib import ExitStack

import pytest

import rosproto
from rosproto.errors import ConnectionLost, RosTimeout
from tests.support.waiting import until
from woosh_pure import Chassis, ChassisError, GoalFailed, OutcomeKind, Pose2D, SimulatedChassis
from woosh_pure.enums import RobotState, TaskState
from woosh_pure.errors import MotionRefused
from woosh_pure.geometry import Velocity
from woosh_pure.reasons import Ready
from woosh_pure.sim import Settings
from woosh_pure.values.messages import message_type


def test_the_state_is_told_at_the_start_and_after_a_silence():
    """The first question is answered; a state of before a silence is told to nobody."""
    with SimulatedChassis(full_graph=False) as sim:
        with Chassis(sim.master_uri) as chassis:
            assert chassis.status.wait(5.0, new=False).robot_state is RobotState.IDLE
            assert chassis.readiness().answer is Ready.YES
        sim.fall_silent(0.5)
        sim.press_emergency_stop()
        with Chassis(sim.master_uri) as chassis:
            assert chassis.status.wait_for(lambda status: status.robot_state is RobotState.FAULT, 5.0)


def files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.skipif(sys.platform != "linux", reason="open files are counted in /proc")
def test_a_whole_robot_needs_few_threads_and_files() -> None:
    """Its twenty nodes share what waits: three robots in one process took 1,024 files."""
    threads, opened = threading.active_count(), files()
    with ExitStack() as stack:
        robots = [stack.enter_context(SimulatedChassis()) for _ in range(2)]
        until(lambda: all(robot.graph.internal_clients["/move_base"].servers for robot in robots))
        # At rest: the last calls and links of the start may still have threads.
        until(lambda: threading.active_count() - threads <= 2 * 40, what="threads at rest")
        until(lambda: files() - opened <= 2 * 60, what="files at rest")
    until(lambda: files() - opened <= 3, what="the end of the robots' sockets")


def test_the_clock_is_right_again_after_the_computer_was_busy(until):
    """A world that stood still for a second does not hurry after it, but what it stamps is not a second old."""
    with SimulatedChassis(full_graph=False) as sim:
        with sim.lock:  # nothing goes on in it meanwhile
            before, began = sim.world.time, time.time()
            while time.time() < began + 1.2:
                time.sleep(0.05)
            assert sim.world.time == before
        until(lambda: abs(time.time() - sim.now) < 0.4)
        assert sim.world.time - before < time.time() - began - 0.9


def test_a_task_drives_through_the_robots_own_client(sim, chassis, until):
    """/ros_interface sends a goal to /move_base, which everybody can see."""
    seen: set[str] = set()
    with rosproto.Node("/onlooker", master_uri=sim.master_uri, anonymous=True) as node:
        node.subscriber(
            "/move_base/status",
            "actionlib_msgs/GoalStatusArray",
            callback=lambda m: seen.update(s.goal_id.id for s in m.status_list),
        )
        chassis.go_to_mark("P1").wait(30.0)
        until(lambda: seen)
    assert all(goal_id.startswith("/ros_interface-") for goal_id in seen)


def test_another_clients_goal_takes_the_base_away_from_a_task(sim, real_time, chassis, until):
    task = chassis.go_to_mark("B1")
    until(lambda: sim.world.motion is not None)
    with Chassis(sim.master_uri) as other:
        drive = other.go_to(1.0, 0.5)
        real_time()
        with pytest.raises(GoalFailed, match="replaced") as caught:
            task.wait(20.0)
        assert caught.value.outcome.kind is OutcomeKind.FAILED
        assert drive.wait(30.0)


def test_a_task_over_points_goes_on_with_the_rest_after_a_pause(sim, real_time, chassis, until):
    from woosh_pure.enums import TaskType

    way = [Pose2D(0.5, 0.0), Pose2D(1.5, 0.0), Pose2D(2.5, 0.0), Pose2D(2.5, 0.8)]
    task = chassis.task(TaskType.PICK, poses=way)
    until(lambda: sim.pose.x > 0.9)
    task.pause()
    chassis.measured_velocity.wait_for(Velocity.is_standing, 10.0)
    held = sim.pose
    task.resume()
    real_time()
    task.wait(30.0)
    assert sim.pose.distance_to(way[-1]) < 0.03
    assert 0.9 < held.x < 2.4


def test_the_plan_of_a_drive_is_published_in_the_small_graph_too(chassis, until):
    until(lambda: chassis.feed("plan").publishers)
    chassis.go_to(2.0, 0.0)
    assert len(chassis.feed("plan").wait(10.0, new=False).poses) > 1


def test_a_pose_in_the_robots_own_frame_is_meant_from_where_it_is(sim, chassis):
    chassis.go_to(1.0, 0.0, math.pi / 2).wait(30.0)
    chassis.go_to(0.5, 0.0, frame="base_link").wait(30.0)
    assert sim.pose.distance_to(Pose2D(1.0, 0.5)) < 0.05
    odometry = chassis.odometry.wait(5.0).pose
    chassis.go_to(odometry.x, odometry.y + 0.3, odometry.yaw, frame="odom").wait(30.0)
    assert sim.pose.distance_to(Pose2D(1.0, 0.8)) < 0.1
    with pytest.raises(GoalFailed, match="no transform from moon"):
        chassis.go_to(0.0, 0.0, frame="moon").wait(10.0)


def test_commands_are_late_on_a_slow_network(sim, chassis, until):
    chassis.enable_costmaps(True)
    with chassis.velocity(bypasses_protection=True) as drive:
        sim.slow_network(0.4)
        drive.set(0.2, valid_for=5.0)
        began = time.monotonic()
        until(lambda: sim.world.body.velocity.vx > 0.0)
        assert time.monotonic() - began >= 0.35
        sim.slow_network(0.0)
    began = time.monotonic()
    sim.slow_network(0.3)
    chassis.enable_costmaps(True)
    assert time.monotonic() - began >= 0.6
    with pytest.raises(ValueError, match="at least 0"):
        sim.slow_network(math.nan)


def test_a_goal_on_a_slow_network_ends_well(sim, chassis):
    sim.slow_network(0.2)
    assert chassis.move(0.3, speed=0.3).wait(20.0)
    sim.speed = 1.0  # time to cancel it on its way
    handle = chassis.go_to(3.0, 2.0)
    assert handle.cancel(10.0).kind is OutcomeKind.CANCELLED
    sim.speed = 8.0
    assert chassis.go_to_mark("P1").wait(30.0)


def test_a_link_that_drops_in_a_velocity_block_ends_it_and_zero_is_what_arrives_last(sim, chassis, until):
    with (  # noqa: PT012
        pytest.raises(ConnectionLost),
        chassis.velocity(bypasses_protection=True, feedback_timeout=0.5) as drive,
    ):
        drive.set(0.1, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.02)
        sim.drop_link(1.5)
        drive.hold(0.1, seconds=20.0)
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0), 10.0)
    assert chassis.measured_velocity.wait(10.0) is not None


def test_a_link_that_drops_in_the_middle_of_a_goal_and_comes_back_loses_nothing(sim, chassis, until):
    handle = chassis.go_to_mark("P1")
    until(lambda: not sim.world.body.velocity.is_standing())
    sim.drop_link(1.0)
    assert handle.wait(30.0).arrived


@pytest.fixture
def impatient(monkeypatch):
    """Nobody will answer: closing does not wait long for it."""
    monkeypatch.setattr("woosh_pure.chassis._CANCEL_SECONDS", 0.4)
    monkeypatch.setattr("woosh_pure.chassis._LATE_SECONDS", 0.2)


def test_a_link_that_stays_away_is_a_lost_connection_and_leaving_says_what_was_not_cancelled(
    sim, real_time, until, monkeypatch, impatient
):
    monkeypatch.setattr("woosh_pure.feed.feed._LOST_AFTER", 0.5)
    chassis = Chassis(sim.master_uri)
    handle = chassis.go_to_mark("B1")
    chassis.measured_velocity.wait(5.0)
    sim.drop_link(60.0)
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CONNECTION_LOST
    with pytest.raises(ConnectionLost, match="may still be driving"):
        chassis.close()
    chassis.close()  # what could not be done has been told; closing again is fine


@pytest.mark.parametrize("arrived", [True, False], ids=["under way", "on its way"])
def test_a_cancel_that_nobody_confirms_is_not_taken_for_done(sim, real_time, until, impatient, arrived):
    """A cancel is a message; on a dead link it is sent, and arrives nowhere. A goal that may still arrive is not done."""
    chassis = Chassis(sim.master_uri)
    chassis.measured_velocity.wait(5.0)
    chassis._components.clients.action("/move_base")
    if not arrived:
        sim.drop_link(60.0)
    handle = chassis.go_to(2.5, 0.0)
    if arrived:
        until(lambda: not sim.world.body.velocity.is_standing())
    chassis._components.clients.action("/move_base")._goals._status_timeout = 0.5
    sim.drop_link(60.0)
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CONNECTION_LOST
    with pytest.raises(ConnectionLost, match="nothing is received from the chassis"):
        handle.cancel(0.3)
    with pytest.raises(ConnectionLost, match="may still be driving"):
        chassis.close()


def test_a_master_that_restarts_in_the_middle_of_a_task_is_not_noticed(sim, chassis, until):
    handle = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    sim.restart_master()
    assert handle.wait(40.0).arrived


def test_a_master_that_restarts_does_not_end_a_velocity_block(sim, chassis, until):
    """What is connected goes on without a master."""
    with chassis.velocity(bypasses_protection=True) as drive:
        until(lambda: drive.set(0.1, valid_for=5.0) or sim.world.body.velocity.vx > 0.02)
        sim.restart_master()
        drive.hold(0.05, seconds=2.0)
        assert drive.active


def test_a_crashed_navigation_ends_the_task_as_failed(sim, real_time, chassis, until):
    handle = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    sim.crash_node("/move_base")
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.FAILED
    with pytest.raises(ValueError, match="is not a node of this chassis"):
        sim.crash_node("/move_bas")


def test_a_robot_that_has_hit_something_drives_again_when_it_is_freed(sim, chassis):
    with pytest.raises(MotionRefused, match="bumper"), chassis.velocity(bypasses_protection=True) as drive:
        drive.hold(0.5, seconds=30.0)
    with pytest.raises(MotionRefused, match="bumper"):
        chassis.go_to(0.0, 0.0)
    sim.release_bumper()
    chassis.wait_until_ready(10.0)
    assert chassis.go_to(0.0, 0.0).wait(30.0)


def test_the_nodes_of_a_robot_do_not_compare_the_graph_of_their_own_master_all_the_time(monkeypatch):
    """Forty of them did, every five seconds: more than half of what an idle simulated chassis cost."""
    asked: list[str] = []
    ask = rosproto.MasterClient.get_system_state

    def note(client, **options):
        asked.append(client.caller_id)
        return ask(client, **options)

    monkeypatch.setattr("rosproto.node.master_monitor.PERIOD", 0.02)
    monkeypatch.setattr("woosh_pure.sim.graph._PERIOD", 0.02)
    monkeypatch.setattr("woosh_pure.sim.graph._SELDOM", 1_000_000)
    monkeypatch.setattr(rosproto.MasterClient, "get_system_state", note)
    with (
        SimulatedChassis(full_graph=False) as sim,
        rosproto.Node("/other", master_uri=sim.master_uri) as other,
    ):
        watched = [other, *sim.graph.nodes.values()]
        until(lambda: min(node._parts.master_monitor._looks for node in watched) >= 10, 60.0, "ten looks")
    assert set(asked) & {node.name for node in watched} == {"/other"}


def test_the_position_is_given_through_the_service_that_is_found_by_its_type(sim, chassis, until):
    sim.lose_localization()
    chassis.set_pose(sim.pose, via="service")
    assert sim.world.located
    with pytest.raises(ChassisError, match="/init_pose"):
        chassis.set_pose(Pose2D(5.0, 2.0), via="service")
    chassis.initialise()


def test_who_knows_the_name_of_an_initialisation_service_says_it(sim, chassis):
    """The names are assumed; and where two services have the type, only the user knows which is meant."""
    called = []
    served = sim.firmware.service_class("woosh_msgs/WooshInit")
    with rosproto.Node("/other", master_uri=sim.master_uri) as node:
        node.service_server("/real_name", served, lambda request: called.append(1) or {"success": True})
        with pytest.raises(ChassisError, match=r"several.*/real_name.*/woosh_init.*service="):
            chassis.initialise()
        chassis.initialise(service="/real_name")
    assert called == [1]


def test_without_initialisation_services_the_error_says_what_else_to_do(sim, chassis):
    for server in [s for s in sim.graph._keep if getattr(s, "name", "") in ("/init_pose", "/woosh_init")]:
        server.close()
    with pytest.raises(ChassisError, match=r"no service of type woosh_msgs/WooshInit.*set_pose"):
        chassis.initialise()


def test_a_pose_that_is_not_in_the_map_is_refused_for_the_localisation(chassis):
    with pytest.raises(ValueError, match="map"):
        chassis.set_pose(Pose2D(0.0, 0.0, 0.0, "odom"))
    with pytest.raises(ValueError, match="via"):
        chassis.set_pose(Pose2D(0.0, 0.0), via="mail")


def test_a_type_whose_definition_is_not_published_is_learned_from_the_robot():
    with (
        SimulatedChassis(full_graph=False, assumed_types=True) as sim,
        Chassis(sim.master_uri) as chassis,
    ):
        volume = chassis.feed("/volume/percent")
        first = volume.wait(5.0, new=False)
        assert first.percent == 50
        chassis.send("/volume/percentSet", type(first)(percent=30))
        assert volume.wait_for(lambda m: m.percent == 30, 5.0)


def test_any_topic_of_the_table_is_written_except_velocities(sim, chassis, until):
    charge = message_type("woosh_msgs/Charge")()
    chassis.send("/charge_cmd", charge)
    until(lambda: "/charge_cmd" in sim.graph.heard)
    with pytest.raises(MotionRefused, match="velocity"):
        chassis.send("/key_cmd_vel", message_type("geometry_msgs/Twist")())
    with pytest.raises(ValueError, match="takes woosh_msgs/Charge, got std_msgs/Bool"):
        chassis.send("/charge_cmd", message_type("std_msgs/Bool")())
    with pytest.raises(ValueError, match="not a topic to write"):
        chassis.send("/battery", charge)
    with pytest.raises(ValueError, match="not a topic to read"):
        chassis.feed("/charge_cmd")
    with pytest.raises(KeyError, match="near names"):
        chassis.send("/charge_cmdd", charge)


def test_equal_seeds_and_equal_commands_give_equal_worlds():
    from woosh_pure.sim import World

    def run(seed):
        world = World(settings=Settings(seed=seed))
        world.navigate("move_base", [Pose2D(2.0, 1.0, 1.0)])
        for _ in range(400):
            world.step(0.02)
        return world.body.pose, world.body.odometry, world.random.random()

    assert run(3) == run(3)
    assert run(3)[1] != run(4)[1]


def test_a_robot_that_is_lost_can_be_told_over_a_whole_session():
    with (
        SimulatedChassis(speed=8, full_graph=False, settings=Settings(located=False)) as sim,
        Chassis(sim.master_uri) as chassis,
    ):
        with pytest.raises(MotionRefused, match="not localised"):
            chassis.go_to_mark("P1")
        chassis.set_pose(sim.pose)
        chassis.wait_until(lambda s: s.robot_state != 1, 10.0)
        assert chassis.go_to_mark("P1").wait(30.0)
        assert chassis.status.latest.task_state is TaskState.COMPLETED


def test_waiting_for_readiness_says_what_is_in_the_way(sim, chassis, until):
    until(lambda: chassis.status_code.publishers)
    sim.press_emergency_stop()
    chassis.readiness()
    sim.release_emergency_stop()
    sim.press_emergency_stop()
    with pytest.raises(RosTimeout, match="emergency stop"):
        chassis.wait_until_ready(0.5)


def test_the_costmap_of_the_navigation_is_told_to_who_listens(sim, chassis, until):
    """With what it has seen; the real one is assumed to name it as move_base does."""
    from woosh_pure.maps.gridmap import grid_from_message

    with chassis.node.subscriber(
        "/move_base/global_costmap/costmap", "nav_msgs/OccupancyGrid", queue_size=1
    ) as told:
        until(lambda: told.latest is not None)
        place = sim.pose
        sim.add_obstacle(place.x + 1.0, place.y)

        def seen() -> bool:
            grid = grid_from_message(told.latest)
            return bool(grid.cells[grid.cell_of(place.x + 1.0, place.y)] == 100)

        until(seen)
    assert told.latest.header.frame_id == "map"
