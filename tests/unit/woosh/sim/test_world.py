"""The simulated world, stepped by hand: no sockets, no threads, no clock."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from rosproto.codec import encode
from woosh_pure.enums import (
    ActionType,
    NavigationMode,
    RobotMode,
    RobotState,
    StepMode,
    TaskCommand,
    TaskState,
    TaskType,
)
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.motion.steps import Step
from woosh_pure.sim.body import BodyLimits
from woosh_pure.sim.motions import MotionState
from woosh_pure.sim.sensors import cast
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.site import Site, built_in_site
from woosh_pure.sim.tasks import TaskRequest
from woosh_pure.sim.world import NavigationSettings, World
from woosh_pure.values.messages import message_type

DT = 0.02


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds / DT)):
        world.step(DT)


def run_until(world: World, condition, most: float = 120.0) -> float:
    start = world.time
    while not condition():
        world.step(DT)
        assert world.time - start < most, "did not happen in time"
    return world.time - start


def execute(task_id: int = 17, mark: str = "A1", kind: TaskType = TaskType.PICK) -> TaskRequest:
    return TaskRequest(TaskCommand.EXECUTE, task_id, kind, mark)


def test_a_smooth_velocity_is_reached_with_the_acceleration_of_the_base():
    world = World()
    world.command_velocity(Velocity(0.3), smooth=True)
    run(world, 0.2)
    assert world.body.velocity.vx == pytest.approx(0.12, abs=1e-9)
    run(world, 1.0)
    assert world.body.velocity.vx == pytest.approx(0.3)


def test_a_direct_velocity_is_reached_faster_than_a_smooth_one():
    smooth, direct = World(), World()
    smooth.command_velocity(Velocity(0.3), smooth=True)
    direct.command_velocity(Velocity(0.3), smooth=False)
    run(smooth, 0.1), run(direct, 0.1)
    assert direct.body.velocity.vx > smooth.body.velocity.vx


def test_when_velocity_messages_end_the_base_drives_on_because_nothing_else_is_documented():
    world = World()
    world.command_velocity(Velocity(0.2), smooth=True)
    run(world, 5.0)
    assert world.body.velocity.vx == pytest.approx(0.2)


def test_on_silence_stop_lets_the_base_stop_by_itself():
    world = World(settings=Settings(on_silence="stop"))
    world.command_velocity(Velocity(0.2), smooth=True)
    run(world, 2.0)
    assert world.body.velocity.is_standing(0.0, 0.0)


def test_a_velocity_into_a_wall_ends_at_the_bumper():
    world = World()
    world.command_velocity(Velocity(-0.5), smooth=True)
    run(world, 10.0)
    assert world.bumper
    assert world.robot_state is RobotState.FAULT
    assert world.body.pose.x == pytest.approx(-1.5 + 0.3, abs=0.08)
    assert 110202000013 in world.take_reports()


def test_a_nan_velocity_is_not_obeyed():
    world = World()
    world.command_velocity(Velocity(math.nan), smooth=True)
    run(world, 0.5)
    assert world.body.velocity == Velocity()


@pytest.mark.parametrize(
    ("step", "expected"),
    [
        (Step(StepMode.STRAIGHT, 0.5), Pose2D(0.5, 0.0, 0.0)),
        (Step(StepMode.STRAIGHT, -0.4, 0.3), Pose2D(-0.4, 0.0, 0.0)),
        (Step(StepMode.ROTATE, math.pi / 2, 0.5), Pose2D(0.0, 0.0, math.pi / 2)),
        (Step(StepMode.ROTATE, -7.0, 1.0), Pose2D(0.0, 0.0, 2 * math.pi - 7.0)),
    ],
)
def test_a_step_ends_where_it_should(step, expected):
    world = World()
    motion = world.step_control([step], avoid=True)
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE
    assert world.body.pose.distance_to(expected) < 0.003
    assert abs(world.body.pose.angle_to(expected)) < 0.003
    assert motion.percent == 100.0


@pytest.mark.parametrize("angle", [1.4e-45, 1e-38, 0.1])
def test_the_part_of_a_step_that_is_done_stays_within_0_and_100(angle):
    """Also of a tiny step that begins while the base turns the other way: no float32 holds -1e40 percent."""
    world = World()
    world.step_control([Step.turn(-60.0, 1.0)], avoid=True)
    run(world, 2.0)
    motion = world.step_control([Step.turn(angle)], avoid=True)
    seen = set()
    for _ in range(1000):
        world.step(DT)
        seen.add(motion.percent)
        encode(message_type("woosh_msgs/StepControlFeedback")(percent=motion.percent))
    assert motion.state is MotionState.DONE
    assert (min(seen), max(seen)) == (0.0, 100.0)


@pytest.mark.parametrize("step", [Step.straight(-10.1), Step.turn(62.9)])
def test_a_step_beyond_the_interfaces_limits_is_not_begun(step):
    """Also one of a program that does not check it, as rospy does not."""
    world = World()
    motion = world.step_control([Step.straight(0.1), step], avoid=True)
    assert (motion.state, motion.code) == (MotionState.FAILED, 120301000032)
    assert world.motion is None


def test_a_lateral_step_is_rejected_by_a_differential_base_and_done_by_an_omnidirectional_one():
    step = Step(StepMode.LATERAL, 0.3)
    assert World().step_control([step], avoid=True).state is MotionState.FAILED
    world = World(settings=Settings(limits=BodyLimits(omnidirectional=True)))
    motion = world.step_control([step], avoid=True)
    run_until(world, lambda: motion.state.is_final)
    assert world.body.pose.y == pytest.approx(0.3, abs=0.003)


def test_a_step_waits_for_an_obstacle_and_goes_on_when_it_is_gone():
    world = World()
    world.obstacles.append((1.0, 0.0, 0.2))
    motion = world.step_control([Step(StepMode.STRAIGHT, 1.5, 0.4)], avoid=True)
    run(world, 6.0)
    assert motion.state is MotionState.RUNNING
    assert world.body.pose.x < 0.5
    world.obstacles.clear()
    run_until(world, lambda: motion.state.is_final)
    assert world.body.pose.x == pytest.approx(1.5, abs=0.003)


def test_what_is_beyond_the_end_of_a_step_does_not_hold_it():
    """0.2 m of room are left at its end."""
    world = World()
    world.obstacles.append((1.0, 0.0, 0.2))
    motion = world.step_control([Step(StepMode.STRAIGHT, 0.3, 0.2)], avoid=True)
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE
    assert world.body.pose.x == pytest.approx(0.3, abs=0.003)


def test_a_step_in_front_of_an_obstacle_fails_when_patience_ends():
    world = World()
    world.obstacles.append((1.0, 0.0, 0.2))
    motion = world.step_control([Step(StepMode.STRAIGHT, 1.5, 0.4)], avoid=True)
    run_until(world, lambda: motion.state.is_final)
    assert (motion.state, motion.code) == (MotionState.FAILED, 130701000032)


def test_pause_and_resume_of_a_combination_give_the_whole_way():
    world = World()
    steps = [Step(StepMode.STRAIGHT, 0.4), Step(StepMode.ROTATE, 1.0, 0.5)]
    world.step_control(steps, avoid=True)
    run(world, 1.0)
    assert world.pause_step()
    rest = world.paused_step.remaining_steps()
    run(world, 2.0)
    assert world.body.velocity.is_standing(0.0, 0.0)
    motion = world.resume_step(rest, avoid=True)
    run_until(world, lambda: motion.state.is_final)
    # What is coasted while the pause brakes is driven twice: some centimetres at 0.2 m/s.
    assert world.body.pose.x == pytest.approx(0.4, abs=0.05)
    assert world.body.pose.yaw == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("mark", ["A1", "A2", "B1", "B2", "P1"])
def test_a_task_drives_to_every_mark(mark):
    world = World()
    assert world.tasks.request(execute(mark=mark)).success
    run_until(world, lambda: not world.tasks.busy)
    assert world.tasks.state is TaskState.COMPLETED
    target = world.site.marks[mark].pose
    assert world.body.pose.distance_to(target) < 0.02
    assert abs(world.body.pose.angle_to(target)) < 0.02
    assert not world.bumper


def test_a_finished_task_stays_visible_as_completed():
    world = World()
    world.tasks.request(execute())
    run_until(world, lambda: not world.tasks.busy)
    run(world, 5.0)
    record = world.status()
    assert (record.task_id, record.task_state) == (17, TaskState.COMPLETED)


def test_a_second_task_is_refused_while_one_runs():
    world = World()
    world.tasks.request(execute())
    reply = world.tasks.request(execute(18))
    assert not reply.success
    assert reply.code == RobotState.IN_TASK


@pytest.mark.parametrize(
    "spoil",
    [
        World.press_emergency_stop,
        World.lose_localization,
        World.plug_cable,
        lambda world: (world.command_velocity(Velocity(-0.5), smooth=True), run(world, 10.0)),
        lambda world: world.set_mode(RobotMode.MANUAL),
    ],
)
def test_a_task_is_refused_when_the_robot_is_not_ready(spoil):
    world = World()
    spoil(world)
    assert not world.tasks.request(execute()).success


def test_a_path_that_is_given_with_a_mark_must_end_there():
    world = World()
    mark = world.site.marks["A1"].pose
    to_another = TaskRequest(TaskCommand.EXECUTE, 17, mark="A1", poses=[mark, Pose2D(0.0, 0.0)])
    assert "does not end at mark 'A1'" in world.tasks.request(to_another).message
    assert world.tasks.request(replace(to_another, poses=[Pose2D(0.0, 0.0), mark])).success


@pytest.mark.parametrize("spoil", [World.press_emergency_stop, World.lose_localization])
def test_a_running_task_fails_and_the_robot_stops(spoil):
    world = World()
    world.tasks.request(execute())
    run(world, 3.0)
    spoil(world)
    run(world, 3.0)
    assert world.tasks.state is TaskState.FAILED
    assert world.body.velocity.is_standing(0.0, 0.0)


def test_nothing_resumes_when_the_emergency_stop_is_released():
    world = World()
    world.tasks.request(execute())
    world.command_velocity(Velocity(0.2), smooth=True)
    run(world, 2.0)
    world.press_emergency_stop()
    run(world, 1.0)
    world.release_emergency_stop()
    run(world, 2.0)
    assert world.body.velocity == Velocity()


def test_pause_resume_and_cancel_of_a_task():
    world = World()
    world.tasks.request(execute())
    run(world, 2.0)
    assert world.tasks.request(TaskRequest(TaskCommand.PAUSE, 17)).success
    run(world, 3.0)
    assert world.body.velocity.is_standing(0.0, 0.0)
    assert world.status().task_state is TaskState.PAUSED
    assert world.tasks.request(TaskRequest(TaskCommand.RESUME, 17)).success
    run(world, 2.0)
    assert not world.tasks.request(TaskRequest(TaskCommand.CANCEL, 99)).success
    assert world.tasks.request(TaskRequest(TaskCommand.CANCEL, 17)).success
    assert world.status().task_state is TaskState.CANCELLED


def test_a_wait_is_interrupted():
    world = World()
    world.tasks.request(execute(mark="W1"))
    run_until(world, lambda: world.tasks.state is TaskState.WAITING_FOR_ACTION)
    assert world.status().action_type is ActionType.WAIT
    assert world.tasks.request(TaskRequest(TaskCommand.INTERRUPT_WAIT, 17)).success
    assert world.tasks.state is TaskState.COMPLETED


def test_charging_fills_the_battery_and_leaving_the_dock_ends_it():
    world = World()
    world.tasks.request(execute(mark="C1", kind=TaskType.CHARGE))
    run_until(world, lambda: not world.tasks.busy)
    assert world.robot_state is RobotState.CHARGING
    before = world.battery.percent
    run(world, 10.0)
    assert world.battery.percent > before
    world.tasks.request(execute(18))
    assert not world.battery.charging


def test_navigation_goes_around_an_obstacle_that_is_not_on_the_map():
    world = World()
    world.obstacles.append((3.0, 0.0, 0.3))
    motion = world.navigate("move_base", [Pose2D(6.0, 0.0)])
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE
    assert not world.bumper


def test_stop_and_wait_waits_for_the_obstacle():
    world = World()
    world.navigation = NavigationSettings(NavigationMode.STOP_AND_WAIT)
    motion = world.navigate("move_base", [Pose2D(2.8, 0.0)])
    run(world, 2.0)
    world.obstacles.append((2.3, 0.0, 0.2))
    run(world, 20.0)
    assert motion.state is MotionState.RUNNING
    assert world.body.velocity.is_standing(0.0, 0.0)
    world.obstacles.clear()
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE


def test_a_new_goal_replaces_the_running_one():
    world = World()
    first = world.navigate("move_base", [Pose2D(2.5, 0.0)])
    run(world, 1.0)
    world.step_control([Step(StepMode.STRAIGHT, 0.1)], avoid=True)
    assert first.state is MotionState.REPLACED


def test_an_unreachable_goal_fails_at_once():
    world = World()
    assert world.navigate("move_base", [Pose2D(50.0, 0.0)]).state is MotionState.FAILED


def test_a_pose_near_the_truth_restores_the_localisation_and_a_wrong_one_does_not():
    world = World()
    world.lose_localization()
    world.initial_pose(Pose2D(5.0, 5.0))
    assert not world.located
    world.initial_pose(Pose2D(0.3, 0.2, 0.1))
    assert world.located
    assert world.believed_pose.distance_to(world.body.pose) < 0.01


def test_equal_seeds_and_commands_give_equal_runs_and_other_seeds_drift_otherwise():
    def odometry(seed: int) -> Pose2D:
        world = World(settings=Settings(seed=seed))
        world.tasks.request(execute())
        run(world, 10.0)
        return world.body.wheel_odometry

    assert odometry(3) == odometry(3)
    assert odometry(3) != odometry(4)


def test_rays_measure_walls_and_obstacles():
    world = World()
    angles = np.array([0.0, math.pi, math.pi / 2])
    ranges = cast(world.site.grid, Pose2D(0.0, 0.0), angles, 30.0)
    assert ranges == pytest.approx([3.5, 1.5, 3.5], abs=0.05)
    ranges = cast(world.site.grid, Pose2D(0.0, 0.0), angles, 30.0, [(2.0, 0.0, 0.5)])
    assert ranges[0] == pytest.approx(1.5, abs=1e-6)
    assert np.isinf(cast(world.site.grid, Pose2D(0.0, 0.0), angles, 3.0)[0])


def turned_map(yaw):
    """The hall, drawn in a picture that lies turned in the map frame: the same walls at the same places."""
    cells = np.zeros((60, 100), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[20:40, 40:45] = 100
    return GridMap(cells, 0.1, Pose2D(-2.0, -3.0, yaw))


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
def test_a_map_whose_origin_is_turned_is_driven_on_and_seen_like_any_other(yaw):
    grid = turned_map(yaw)
    start, goal = (Pose2D(*grid.point_of(*cell), yaw) for cell in ((30, 20), (30, 80)))
    world = World(Site(grid, {}, start), Settings(seed=1))
    ranges = cast(grid, world.body.pose, np.array([0.0, math.pi]), 30.0)
    assert ranges == pytest.approx([1.95, 1.95], abs=0.1)
    motion = world.navigate("move_base", [goal])
    for _ in range(3000):
        world.step(0.02)
        if motion.state.is_final:
            break
    assert motion.state is MotionState.DONE
    assert world.body.pose.distance_to(goal) < 0.03


def test_on_a_map_of_somebodys_the_robot_begins_where_there_is_room():
    grid = turned_map(0.0)
    inside_the_block = Pose2D(*grid.point_of(30, 42), 1.0)
    world = World(Site(grid, {}, inside_the_block))
    assert world.planner.is_free(world.body.pose.x, world.body.pose.y)
    assert world.body.pose.distance_to(inside_the_block) < 1.0
    far_off = World(Site(grid, {}, Pose2D(500.0, 500.0)))
    assert grid.contains(far_off.body.pose.x, far_off.body.pose.y)
    full = GridMap(np.full((10, 10), 100, np.int8), 0.1)
    with pytest.raises(ValueError, match="no free place"):
        World(Site(full, {}))


@pytest.mark.parametrize(("start", "end"), [("A2", "B1"), ("B1", "A1"), ("B1", "A2"), ("B1", "P1")])
def test_the_robot_passes_the_pillars_of_its_own_hall(start, end):
    """Planned over the middles of cells, it grazed a pillar on these four of the 42 ways between marks."""
    marks = built_in_site().marks
    world = World(settings=Settings(start=marks[start].pose))
    motion = world.navigate("move_base", [marks[end].pose])
    for _ in range(1200):
        world.step(0.05)
        if motion.state.is_final:
            break
    assert motion.state is MotionState.DONE
    assert not world.bumper


def some_free_place(world: World, chance: random.Random) -> Pose2D:
    while True:
        place = Pose2D(chance.uniform(-1.1, 9.1), chance.uniform(-3.1, 3.1), chance.uniform(-3.0, 3.0))
        if world.planner.is_free(place.x, place.y):
            return place


@pytest.mark.parametrize("seed", [0, 7, 8])
@pytest.mark.parametrize("dt", [0.02, 0.05])
def test_goals_replaced_cancelled_and_paused_at_speed_never_end_at_the_bumper(seed, dt):
    """It turned towards the new goal while it still rolled, off its way, and into a pillar; or, too near to one
    already, planned its way out through it."""
    chance = random.Random(seed)
    world = World(settings=Settings(seed=seed))
    arrived, due = 0, 0.0
    motion = world.navigate("move_base", [some_free_place(world, chance)])
    while world.time < 60.0:
        if world.time >= due:
            due = world.time + chance.uniform(0.3, 6.0)
            arrived += motion.state is MotionState.DONE
            if chance.random() < 0.2 and world.motion is not None:
                world.end_motion(world.motion, MotionState.CANCELLED)
            elif chance.random() < 0.2 and world.motion is not None:
                world.motion.pause()
            else:
                motion = world.navigate("move_base", [some_free_place(world, chance)])
        world.step(dt)
        assert not world.bumper, (world.time, world.body.pose)
    motion = world.navigate("move_base", [some_free_place(world, chance)])
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE, "it brakes, and goes on"


def test_the_way_out_of_a_tight_place_does_not_lead_through_the_wall():
    """A wall was left as any near place was: five times as dear, and so cheaper than the way around it."""
    cells = np.zeros((120, 200), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[0:100, 101:103] = 100
    grid = GridMap(cells, 0.05, Pose2D(0.0, 0.0))
    world = World(Site(grid, {}, Pose2D(2.0, 2.0)))
    world.body.pose = Pose2D(4.72, 1.0, 0.0)
    assert not world.collisions.touches(4.72, 1.0)
    path = world.plan(world.body.pose, Pose2D(6.5, 1.0))
    assert path is not None
    assert max(pose.y for pose in path) > 4.5
    motion = world.navigate("move_base", [Pose2D(6.5, 1.0)])
    run_until(world, lambda: motion.state.is_final)
    assert motion.state is MotionState.DONE
    assert not world.bumper


def test_a_velocity_still_bypasses_the_protection():
    """What drives by velocities has no braking distance kept for it: at the bumper it ends."""
    world = World()
    motion = world.navigate("move_base", [Pose2D(2.5, 0.0)])
    run(world, 1.0)
    world.end_motion(motion, MotionState.CANCELLED)
    world.command_velocity(Velocity(0.8), smooth=True)
    run(world, 8.0)
    assert world.bumper


HALL = built_in_site()


def spoilt() -> World:
    """A world in which all that `reset` mends is as it was not at the start, with a task under way."""
    world = World(HALL, Settings(battery_percent=60.0))
    world.tasks.request(execute(mark="B1"))
    run(world, 3.0)
    world.set_map(GridMap(np.zeros((40, 40), np.int8), 0.05), world.body.pose)
    world.navigation = NavigationSettings(NavigationMode.STOP_AND_WAIT)
    world.obstacles.append((3.0, 0.0, 0.25))
    world.battery.percent = 3.0
    return world


def state_of(world: World) -> object:
    return (
        world.body.pose, world.body.odometry, world.battery.percent, world.status(), world.robot_state, world.motion,
        world.navigation, world.map_seen, world.obstacles, world.collisions.seen_obstacles, world.last_code,
    )  # fmt: skip


@pytest.mark.parametrize(
    "spoil",
    [
        lambda world: None,
        World.press_emergency_stop,
        World.lose_localization,
        World.plug_cable,
        lambda world: world.set_mode(RobotMode.MANUAL),
        lambda world: setattr(world.tasks, "fail_next", "injected"),
    ],
)
def test_a_reset_ends_the_task_and_puts_everything_back(spoil):
    world, fresh = spoilt(), World(HALL, Settings(battery_percent=60.0))
    spoil(world)
    motion, time = world.motion, world.time
    world.interrupt("the simulation was reset")
    assert world.tasks.state is TaskState.FAILED
    assert motion is None or motion.state is MotionState.FAILED
    world.reset()
    assert state_of(world) == state_of(fresh)
    assert world.time == time
    assert world.tasks.request(execute()).success
    world.step(DT)
    assert world.tasks.busy


def test_a_reset_reports_the_end_of_every_fault():
    """A client keeps a fault until its submodule is normal again, the injected ones too."""
    from woosh_pure.faults import ActiveFaults

    world, client = World(), ActiveFaults()
    world.press_emergency_stop()
    world.lose_localization()
    for code in (110301000013, 140201000022, 110202000013):
        world.report(code)
    world.reset()
    for code in world.take_reports():
        client.receive(code)
    assert client.active == ()


def test_a_robot_that_is_carried_is_localised_and_has_no_task():
    world = World()
    world.tasks.request(execute(mark="B1"))
    run(world, 2.0)
    odometry = world.body.odometry
    world.lose_localization()
    world.teleport(4.0, 1.5, math.pi / 2)
    assert world.body.pose == world.believed_pose == Pose2D(4.0, 1.5, math.pi / 2)
    assert world.located
    assert world.body.odometry == odometry  # the wheels have not turned
    assert world.tasks.state is TaskState.FAILED
    run(world, 1.0)
    assert world.body.pose == Pose2D(4.0, 1.5, math.pi / 2)
    world.teleport(0.0, 0.0)
    assert world.body.pose.yaw == math.pi / 2


def test_a_robot_that_is_carried_out_of_its_collision_is_free():
    world = World()
    world.command_velocity(Velocity(-0.5), smooth=True)
    run_until(world, lambda: world.bumper)
    world.teleport(3.0, 0.0, 0.0)
    assert not world.bumper
    assert world.robot_state is RobotState.IDLE


@pytest.mark.parametrize("place", [(-9.0, 0.0), (2.0, 2.0), (-1.6, 0.0), (math.nan, 0.0), (1e9, 0.0)])
def test_nobody_puts_the_robot_into_a_wall(place):
    world = World()
    world.obstacles.append((2.0, 2.0, 0.25))
    world.tasks.request(execute())
    with pytest.raises(ValueError):
        world.teleport(*place)
    assert world.tasks.busy
    assert world.body.pose == Pose2D(0.0, 0.0)
