"""What a program does wrong with the API, and what it is told: before anything is sent, and never by a hang."""

from __future__ import annotations

import math
import sys
import threading

import pytest

import rosproto
from rosproto.errors import ConnectionLost, LocalProtocolError, RosError
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, Pose2D
from woosh_pure.enums import Direction, LedState, NavigationMode, TaskState, TaskType
from woosh_pure.geometry import Footprint
from woosh_pure.motion.steps import Step

SQUARE = [(0.4, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.4, -0.3)]


@pytest.fixture(scope="module")
def robot():
    """One robot for all that is refused before it is sent: nothing ever reaches it."""
    from woosh_pure import SimulatedChassis

    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        yield chassis
        assert sim.world.body.distance == 0.0


@pytest.mark.parametrize(
    ("call", "match"),
    [
        # another unit
        (lambda c: c.go_to(1.0, 0.0, 90), "math.radians"),
        (lambda c: c.follow([Pose2D(1.0, 0.0, 180)]), "math.radians"),
        (lambda c: c.task(TaskType.PICK, poses=[Pose2D(1, 0, 90)]), "math.radians"),
        (lambda c: c.set_pose(Pose2D(0, 0, 90)), "math.radians"),
        (lambda c: c.plan(Pose2D(1, 0, 90)), "math.radians"),
        (lambda c: c.rotate(45), "degrees=True"),
        (lambda c: c.steps([Step.straight(0.1), Step.turn(45)]), "degrees=True"),
        (lambda c: c.move_diagonal(0.1, 45), "degrees=True"),
        (lambda c: c.move(500), "10.0 m"),
        (lambda c: c.move(0.5, speed=200), "another unit"),
        (lambda c: c.rotate(0.5, speed=30), "another unit"),
        (lambda c: c.set_navigation_mode(NavigationMode.STOP_AND_WAIT, max_speed=400), "another unit"),
        (lambda c: c.set_footprint([(400, 300), (-400, 300), (-400, -300), (400, -300)]), "metres"),
        # no number
        (lambda c: c.go_to(math.nan, 0.0), "finite"),
        (lambda c: c.set_pose(Pose2D(math.inf, 0.0)), "finite"),
        (lambda c: c.set_pose(Pose2D(0.0, 0.0), position_deviation=-1.0), "positive"),
        (lambda c: c.set_footprint(SQUARE, padding=math.nan), "padding"),
        (lambda c: c.set_footprint(SQUARE, padding=-1.0), "padding"),
        (lambda c: c.set_footprint([1, 2, 3]), "corners"),
        (lambda c: c.velocity(bypasses_protection=True, feedback_timeout=math.nan), "feedback_timeout"),
        (lambda c: c.velocity(bypasses_protection=True, max_linear=-0.1), "max_linear"),
        (lambda c: c.go_to_mark("A1", timeout=math.nan), "timeout"),
        (lambda c: c.move(0.1, timeout=-1.0), "timeout"),
        (lambda c: c.wait_until(bool, timeout=math.nan), "timeout"),
        (lambda c: c.wait_until_ready(-1.0), "timeout"),
        (lambda c: c.plan(Pose2D(1, 0), tolerance=math.nan), "tolerance"),
        # not what the interface knows
        (lambda c: c.go_to_mark(101), "as text"),
        (lambda c: c.go_to_mark(""), "mark or poses"),
        (lambda c: c.task(TaskType.UNDEFINED, "A1"), "expected one of pick"),
        (lambda c: c.task(TaskType(77), "A1"), "expected one of pick"),
        (lambda c: c.carry("A1", Direction(7)), "direction"),
        (lambda c: c.carry("A1", "load"), "load"),
        (lambda c: c.task(TaskType.PICK, "A1", custom=300), "custom"),
        (lambda c: c.task(TaskType.PICK, "A1", type_number=-1), "type_number"),
        (lambda c: c.go_to(1.0, 0.0, frame=""), "frame"),
        (lambda c: c.light(color=(0.5, 0, 0)), "whole numbers"),
        (lambda c: c.light(color=[255, 0]), "red, green, blue"),
        (lambda c: c.light(color="mauve"), "six hexadecimal digits RRGGBB, or red, orange"),
        (lambda c: c.light("红色"), r"did you mean red\?"),
        (lambda c: c.light("reddish"), "task-paused, .*red, "),
        (lambda c: c.light(LedState(999)), "999"),
        (lambda c: c.set_footprint(SQUARE, local=False, global_=False), "nothing would be sent"),
        (lambda c: c.set_navigation_mode(NavigationMode(9)), "expected 0 to 3"),
        (lambda c: c.set_navigation_mode(3), "waiting_timeout"),  # also as a number
    ],
)
def test_what_cannot_be_meant_is_a_value_error(robot, call, match):
    with pytest.raises(ValueError, match=match):
        call(robot)
    assert not robot.moved


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda c: c.follow([(1.0, 2.0, 0.0)]), "expected Pose2D"),
        (lambda c: c.plan(3.0, 1.0), r"^[13]\.0 is not a pose; expected Pose2D"),
        (lambda c: c.plan(Pose2D(1, 0), 0.0), r"^0\.0 is not a pose; expected Pose2D"),
        (lambda c: c.set_pose(3.0), "expected Pose2D"),
        (lambda c: c.task(TaskType.PICK, poses=[3.0]), "expected Pose2D"),
        (lambda c: c.steps([0.5]), "Step.straight"),
        (lambda c: c.set_map("hall.yaml"), "GridMap"),
    ],
)
def test_another_type_is_told_with_the_right_one(robot, call, match):
    with pytest.raises(TypeError, match=match):
        call(robot)


@pytest.mark.parametrize(
    "address", ["http://", "robot:port", "two words", "https://robot", 5, "http://robot:99999"]
)
def test_an_address_that_is_none_is_told_at_once(address):
    with pytest.raises(ValueError, match=r"URI|address"):
        Chassis(address)


def test_a_time_limit_of_a_chassis_is_a_time():
    for timeout in (math.nan, 0.0, -1.0, math.inf):
        with pytest.raises(ValueError, match="timeout"):
            Chassis("127.0.0.1", timeout=timeout)


def test_a_single_pose_and_a_single_step_are_understood(sim, chassis):
    chassis.follow(Pose2D(0.3, 0.0)).wait(20.0)
    chassis.steps(Step.straight(0.2)).wait()
    assert sim.pose.x == pytest.approx(0.5, abs=0.03)


def test_after_close_every_verb_says_so_at_once(sim):
    chassis = Chassis(sim.master_uri, timeout=30.0)  # none of them may wait that long
    chassis.battery.wait(5.0)
    chassis.light()
    with pytest.raises(MotionRefused):
        chassis.velocity(bypasses_protection=False)
    chassis.move(0.05).wait()
    chassis.close()
    assert chassis.battery.latest is not None  # what was heard can still be read
    calls = [
        lambda: chassis.go_to_mark("A1"),
        lambda: chassis.go_to(1.0, 0.0),
        lambda: chassis.move(0.1),
        lambda: chassis.velocity(bypasses_protection=True),
        lambda: chassis.light(),
        lambda: chassis.say("x"),
        lambda: chassis.set_footprint(SQUARE),
        lambda: chassis.clear_costmaps(),
        lambda: chassis.get_map(),
        lambda: chassis.battery.wait(),
        lambda: chassis.imu.latest,
        lambda: chassis.readiness(),
        lambda: chassis.snapshot(),
        lambda: chassis.__enter__(),
    ]
    for call in calls:
        with pytest.raises(ConnectionLost, match="closed"):
            call()
    report = chassis.stop(timeout=1.0)
    assert report.standing is None
    assert any("closed" in problem for problem in report.problems)


def test_stop_never_raises_whatever_the_state():
    report = Chassis("127.0.0.1:1", timeout=0.5).stop(timeout=math.nan)
    assert report.standing is None
    assert report.problems
    assert "not known" in report.sentence()
    assert Chassis("127.0.0.1:1", timeout=0.5).stop(everything=True, timeout=1.0).problems


def test_a_goal_and_a_velocity_block_do_not_fight_for_the_base(sim, real_time, chassis, until):
    with chassis.velocity(bypasses_protection=True):
        for call in (
            lambda: chassis.move(0.1),
            lambda: chassis.go_to(1, 0),
            lambda: chassis.go_to_mark("A1"),
        ):
            with pytest.raises(MotionRefused, match="velocity block is open"):
                call()
    task = chassis.go_to_mark("B1")
    with pytest.raises(MotionRefused, match="is under way"), chassis.velocity(bypasses_protection=True):
        pass
    task.pause()
    chassis.wait_until(lambda s: s.task_state is TaskState.PAUSED, 10.0)
    with chassis.velocity(bypasses_protection=True) as drive:  # a held task may be driven around
        assert drive.active
    task.resume()
    real_time()
    assert task.wait(30.0)


def test_a_replacing_goal_that_is_refused_for_a_velocity_block_ends_nothing(sim, chassis):
    task = chassis.go_to_mark("B1")
    with chassis.velocity(bypasses_protection=True, check=False):
        for call in (
            lambda: chassis.go_to(1, 0, replace=True),
            lambda: chassis.move(0.1, replace=True),
            lambda: chassis.go_to_mark("A1", replace=True),
        ):
            with pytest.raises(MotionRefused, match="velocity block is open"):
                call()
    assert not task.done
    assert not task.cancel().arrived


def test_a_drive_that_could_not_be_opened_takes_no_velocity(sim, chassis):
    with chassis.velocity(bypasses_protection=True):
        second = chassis.velocity(bypasses_protection=True)
        with pytest.raises(MotionRefused, match="another"):
            second.__enter__()
        with pytest.raises(MotionRefused):
            second.set(0.1)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_drive_in_a_thread_that_dies_stops(sim, chassis, until):
    def drive_and_die():
        with chassis.velocity(bypasses_protection=True) as drive:
            drive.set(0.2, valid_for=5.0)
            until(lambda: sim.world.body.velocity.vx > 0.02)
            sys.exit()

    thread = threading.Thread(target=drive_and_die)
    thread.start()
    thread.join(20.0)
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


def test_waiting_for_a_goal_in_its_own_callback_is_an_error_and_not_a_hang(sim, chassis, caplog):
    handle = chassis.go_to(1.0, 0.0)
    problems: list[BaseException] = []

    def wait_for_itself(_):
        try:
            handle.wait(30.0)
        except LocalProtocolError as error:
            problems.append(error)

    handle.on_progress(wait_for_itself)
    assert handle.wait(20.0)
    assert problems
    assert "would never end" in str(problems[0])


def test_a_callback_may_cancel_and_may_stop(sim, real_time, chassis, until):
    handle = chassis.go_to(2.5, 0.0)
    handle.on_progress(lambda _: handle.cancel())
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CANCELLED
    task = chassis.go_to_mark("B1")
    reports = []
    chassis.measured_velocity.on(lambda v: reports.append(chassis.stop(timeout=2.0)) if v.vx > 0.1 else None)
    assert task.wait(20.0, raises=False).kind is OutcomeKind.CANCELLED
    until(lambda: reports)  # it looks whether the robot stands
    assert reports[0].cancelled


def test_many_threads_read_and_drive_at_once(sim, chassis):
    problems: list[BaseException] = []

    def work(number):
        try:
            for _ in range(3):
                chassis.pose.wait(10.0)
                chassis.battery.latest  # noqa: B018
                chassis.readiness()
                chassis.light(color=number)
        except BaseException as error:
            problems.append(error)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    for thread in threads:
        thread.start()
    assert chassis.go_to(1.0, 0.5).wait(30.0)
    for thread in threads:
        thread.join(30.0)
    assert problems == []


def test_stop_does_not_wait_for_a_verb_that_cannot_connect(sim, chassis, until):
    """Another thread hangs in a verb; the button of the program still works, and the drive stays alive."""
    release = threading.Event()
    original = rosproto.Node.publisher

    def slow(node, topic, *arguments, **options):
        if topic == "/voice_synthesis":
            release.wait(20.0)
        return original(node, topic, *arguments, **options)

    with (  # noqa: PT012
        pytest.MonkeyPatch.context() as patch,
        pytest.raises(MotionRefused),
        chassis.velocity(bypasses_protection=True) as drive,
    ):
        patch.setattr(rosproto.Node, "publisher", slow)
        talker = threading.Thread(target=lambda: chassis.say("x"))
        talker.start()
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.02)
        chassis.stop(timeout=2.0)
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
        release.set()
        talker.join(20.0)


def test_two_programs_that_compete_are_told_of_each_other(sim, real_time, chassis, until):
    with Chassis(chassis.node.master_uri) as other:
        theirs = other.go_to_mark("B1")
        until(lambda: any(r.key == "other_client" for r in chassis.readiness().reasons))
        with pytest.raises(MotionRefused, match=r"another task is running.*of another client"):
            chassis.go_to_mark("A1")
        theirs.cancel()
        drive = other.go_to(2.5, 0.0)
        until(lambda: "/move_base" in chassis.readiness().sentence())
        ours = chassis.go_to(0.5, 0.5)
        with pytest.raises(GoalFailed) as caught:
            drive.wait(20.0)
        assert caught.value.outcome.kind is OutcomeKind.REPLACED
        real_time()
        assert ours.wait(20.0)


@pytest.mark.promise("`chassis.stop(everything=True)`, `woosh stop`")
def test_stopping_everything_names_another_program_that_drives_by_velocity(sim, chassis):
    assert chassis.stop(everything=True).problems == []
    with Chassis(chassis.node.master_uri) as other, other.velocity(bypasses_protection=True):
        problems = chassis.stop(everything=True).problems
        assert any(other.node.name in problem and "end it" in problem for problem in problems)


def test_a_fault_that_ends_a_task_here_ends_it_on_the_robot_too(sim, real_time, chassis, until):
    """The robot may recover by itself and drive on, while the program has been told that it failed."""
    handle = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    from woosh_pure.sim.chassis import SimulatedChassis as Kind

    assert isinstance(sim, Kind)
    publisher = sim.graph.first("/robot_status")
    status = publisher.message_class(task_id=handle.task_id, task_state=3, robot_state=6, msg="overheated")
    publisher.publish(status)
    outcome = handle.wait(20.0, raises=False)
    assert outcome.kind is OutcomeKind.FAILED
    assert "overheated" in outcome.text
    until(lambda: sim.world.tasks.state is TaskState.CANCELLED)


@pytest.mark.promise("the `Chassis` block is left, or the program ends in an orderly way")
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, SystemExit])
def test_whatever_leaves_the_block_stops_the_robot(sim, until, error):
    with pytest.raises(error), Chassis(sim.master_uri) as chassis:  # noqa: PT012
        chassis.go_to(2.5, 0.0)
        until(lambda: not sim.world.body.velocity.is_standing())
        raise error
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
    assert sim.world.motion is None


def test_errors_are_ros_errors_or_value_errors(robot):
    """One `except` catches what the robot says, another what the caller got wrong."""
    assert issubclass(GoalFailed, RosError)
    assert issubclass(MotionRefused, RosError)
    with pytest.raises(ValueError, match="3 corners"):
        Footprint.from_points([(0, 0), (1, 1)])
