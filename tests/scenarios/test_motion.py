"""Navigation, precise moves and velocity over real TCP."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from rosproto.errors import ConnectionLost
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, Pose2D, SimulatedChassis, StaleState
from woosh_pure.enums import RobotMode
from woosh_pure.geometry import Velocity
from woosh_pure.motion.steps import Step
from woosh_pure.sim import Settings
from woosh_pure.sim.body import BodyLimits
from woosh_pure.velocity.shaper import DriveLimits, Shaper


def test_go_to_a_pose(sim, chassis):
    handle = chassis.go_to(2.0, 1.0, math.pi / 2)
    seen = list(handle.reports())
    assert handle.wait(20.0).arrived
    assert sim.pose.distance_to(Pose2D(2.0, 1.0)) < 0.03
    assert seen


def test_follow_a_path_point_by_point(sim, chassis):
    path = [Pose2D(1.0, 0.0), Pose2D(1.0, 1.0), Pose2D(0.0, 1.0)]
    chassis.follow(path, point_by_point=True).wait(30.0)
    assert sim.pose.distance_to(path[-1]) < 0.03


def test_a_place_that_cannot_be_reached_is_an_error(chassis):
    with pytest.raises(GoalFailed) as caught:
        chassis.go_to(50.0, 0.0).wait(20.0)
    assert caught.value.outcome.kind is OutcomeKind.FAILED


def test_a_goal_of_the_robot_itself_replaces_ours_and_is_told(sim, real_time, chassis, until):
    handle = chassis.go_to(2.5, 0.0)
    until(lambda: not sim.world.body.velocity.is_standing())
    sim.compete(0.0, 1.0)
    with pytest.raises(GoalFailed) as caught:
        handle.wait(10.0)
    assert caught.value.outcome.kind is OutcomeKind.REPLACED


@pytest.mark.promise("`handle.wait(timeout=...)` runs out")
def test_a_navigation_timeout_cancels_and_confirms_the_stop(sim, real_time, chassis):
    with pytest.raises(GoalFailed) as caught:
        chassis.go_to(2.8, 0.0).wait(0.3)
    outcome = caught.value.outcome
    assert (outcome.kind, outcome.stopped) == (OutcomeKind.TIMED_OUT, True)
    with sim.lock:
        assert sim.world.motion is None


def test_move_and_rotate(sim, chassis):
    chassis.move(0.5).wait()
    assert sim.pose.x == pytest.approx(0.5, abs=0.01)
    chassis.rotate(90, degrees=True, speed=0.5).wait()
    assert sim.pose.yaw == pytest.approx(math.pi / 2, abs=0.01)
    chassis.move(-0.3).wait()
    assert sim.pose.y == pytest.approx(-0.3, abs=0.01)


def test_several_steps_as_one_goal(sim, chassis):
    steps = [Step.straight(0.4), Step.turn(math.pi / 2, 1.0), Step.straight(0.2)]
    handle = chassis.steps(steps)
    indices = [len(steps) - len(handle.remaining()) for _ in handle.reports()]
    handle.wait()
    assert sim.pose.distance_to(Pose2D(0.4, 0.2)) < 0.02
    assert indices == sorted(indices)
    assert handle.progress.percent == 100.0


def test_pause_and_resume_of_steps_send_what_remains(sim, real_time, chassis, until):
    handle = chassis.steps([Step.straight(0.8), Step.turn(1.0, 1.0)])
    until(lambda: handle.latest_report and handle.latest_report.percent > 20)
    handle.pause()
    chassis.measured_velocity.wait_for(Velocity.is_standing, 5.0)
    held = sim.pose
    time.sleep(0.2)
    assert sim.pose.distance_to(held) < 0.01
    assert not handle.done
    assert len(handle.remaining()) == 2
    handle.resume()
    real_time()
    handle.wait(20.0)
    assert sim.pose.x == pytest.approx(0.8, abs=0.1)  # the steps are resent from what the pause reported
    assert sim.pose.yaw == pytest.approx(1.0, abs=0.02)


def test_a_lateral_step_is_an_error_on_a_differential_base_and_works_on_another(chassis):
    with pytest.raises(GoalFailed):
        chassis.strafe(0.3).wait(5.0)
    settings = Settings(limits=BodyLimits(omnidirectional=True))
    with (
        SimulatedChassis(speed=8, settings=settings, full_graph=False) as omni,
        Chassis(omni.master_uri) as other,
    ):
        other.strafe(0.3).wait()
        assert omni.pose.y == pytest.approx(0.3, abs=0.01)
        other.move_diagonal(0.4, 45, degrees=True).wait()
        assert omni.pose.x == pytest.approx(0.4 * math.cos(math.pi / 4), abs=0.01)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda c: c.move(10.1), "10.0 m"),
        (lambda c: c.move(math.nan), "^straight nan m: every number must be finite$"),
        (lambda c: c.left(math.nan), "finite"),
        (lambda c: c.rotate(90), "degrees=True"),
        (lambda c: c.rotate(63.0, several_turns=True), "62.8318"),
        (lambda c: c.left(3601), r"3601° is more than the 3600° \(ten turns\)"),
        (lambda c: c.move(1.0, speed=-0.1), "positive"),
        (lambda c: c.steps([]), "no steps"),
        (lambda c: c.move(0), "the way is 0"),
        (lambda c: c.strafe(-0.0, replace=True), "the way is 0"),
        (lambda c: c.left(0), "the way is 0"),
        (lambda c: c.steps([Step.straight(0), Step.turn(0)]), "the way is 0"),
        (lambda c: c.go_to(math.inf, 0.0), "finite"),
        (lambda c: c.follow([]), "empty"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_anything_is_sent(chassis, call, match):
    with pytest.raises(ValueError, match=match):
        call(chassis)
    assert not chassis.moved


def test_a_blocked_step_is_an_error(sim, chassis):
    sim.add_obstacle(1.0, 0.0)
    with pytest.raises(GoalFailed) as caught:
        chassis.move(2.0, speed=0.5).wait(20.0)
    assert caught.value.outcome.kind is OutcomeKind.FAILED
    assert sim.pose.x < 0.6


# -- velocity --------------------------------------------------------------------------------------------------


@pytest.mark.promise("the velocity block is left, or an exception leaves it")
def test_a_velocity_block_moves_and_ends_in_zero(sim, real_time, chassis, until):
    with chassis.velocity(bypasses_protection=True) as drive:
        # By distance: how far it gets in a time depends on how busy this computer is.
        while sim.pose.x < 0.3:
            drive.hold(0.2, seconds=0.1)
        drive.set(0.2)
        until(lambda: sim.world.body.velocity.vx > 0.1)
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.promise("the velocity block is left, or an exception leaves it")
def test_an_exception_in_the_block_ends_in_zero(sim, real_time, chassis, until):
    with pytest.raises(ZeroDivisionError), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012  (the error must come out of the block)
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.1)
        raise ZeroDivisionError
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.promise("a velocity is not repeated within")
def test_a_command_that_is_not_refreshed_lapses(sim, real_time, chassis, until):
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.2, valid_for=2.0)
        until(lambda: sim.world.body.velocity.vx > 0.02)
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
        assert drive.active
        drive.set(0.1, valid_for=2.0)
        until(lambda: sim.world.body.velocity.vx > 0.02)


def test_a_command_that_was_on_its_way_counts_from_when_it_was_made(sim, real_time, chassis, until):
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.2, valid_for=5.0, since=time.monotonic() - 10.0)  # it lapsed long ago
        with pytest.raises(ValueError, match="since=nan"):
            drive.set(0.2, since=math.nan)
        with pytest.raises(AssertionError):
            until(lambda: drive.sending.vx > 0.0, timeout=0.3)
        drive.set(0.2, valid_for=3.0, since=time.monotonic() + 100.0)  # nothing was made in the future
        until(lambda: sim.world.body.velocity.vx > 0.02)
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.promise("emergency stop, key switch to manual")
def test_an_emergency_stop_ends_a_drive_and_releasing_it_resumes_nothing(sim, real_time, chassis, until):
    with (  # noqa: PT012
        pytest.raises(MotionRefused, match="emergency stop") as caught,
        chassis.velocity(bypasses_protection=True) as drive,
    ):
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.02)
        sim.press_emergency_stop()
        until(lambda: not drive.active)
        sim.release_emergency_stop()
        drive.set(0.2)
    assert not caught.value.readiness.ready
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
    chassis.wait_until_ready(10.0)
    assert sim.world.body.velocity.is_standing(0.0, 0.0)


@pytest.mark.promise("emergency stop, key switch to manual")
def test_turning_the_key_to_manual_ends_a_drive(sim, real_time, chassis, until):
    with pytest.raises(MotionRefused, match="manual"), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012
        sim.set_mode(RobotMode.MANUAL)
        drive.hold(0.1, seconds=10.0)


@pytest.mark.parametrize(("silence", "ends"), [(0.3, False), (30.0, True)])
def test_the_feedback_timeout_is_what_the_caller_says(sim, real_time, chassis, silence, ends):
    """A shorter silence is survived; a longer one ends the drive, and an error that was raised comes once."""
    with chassis.velocity(bypasses_protection=True, feedback_timeout=2.0) as drive:
        chassis.measured_velocity.wait(5.0)
        sim.fall_silent(silence)
        if ends:
            with pytest.raises(ConnectionLost, match=r"2\.0 s"):
                drive.hold(0.1, seconds=15.0)
        else:
            chassis.measured_velocity.wait(5.0)
            assert drive.active
    assert drive.active is False


def test_without_acknowledgement_there_is_no_velocity(chassis):
    with pytest.raises(MotionRefused, match="bypasses"):
        chassis.velocity(bypasses_protection=False)
    with pytest.raises(TypeError):
        chassis.velocity()


@pytest.mark.parametrize("bad", [(math.nan, 0.0), (5.0, 0.0), (0.0, math.inf), (0.0, 9.0)])
def test_a_velocity_out_of_range_is_refused_not_clamped(chassis, bad):
    with (
        chassis.velocity(bypasses_protection=True) as drive,
        pytest.raises(ValueError, match=r"limit|finite"),
    ):
        drive.set(*bad)


def test_limits_come_from_the_chassis_and_the_caller_may_only_lower_them(chassis):
    with chassis.velocity(bypasses_protection=True) as drive:
        assert (drive.limits.linear, drive.limits.angular) == (1.0, 1.0)
    with (
        chassis.velocity(bypasses_protection=True, max_linear=0.1) as drive,
        pytest.raises(ValueError, match=r"0\.1"),
    ):
        drive.set(0.2)
    with pytest.raises(ValueError, match="at most"):
        chassis.velocity(bypasses_protection=True, max_linear=3.0)


def test_a_silent_parameter_topic_leaves_the_careful_limits():
    with SimulatedChassis(full_graph=False) as sim:
        sim.graph.first("/driver_base/parameter").close()
        with Chassis(sim.master_uri) as chassis:
            assert chassis.velocity(bypasses_protection=True).limits == DriveLimits(0.3, 0.5)


@pytest.mark.promise("`chassis.stop()`, from any thread")
def test_stop_ends_a_drive_and_it_cannot_be_revived(sim, real_time, chassis, until):
    with pytest.raises(MotionRefused, match="stop"), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012  (the error must come out of the block)
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.1)
        thread = threading.Thread(target=chassis.stop)
        thread.start()
        thread.join(10.0)
        assert sim.world.body.velocity.is_standing()
        drive.set(0.2)
    time.sleep(0.2)
    assert sim.world.body.velocity.is_standing(0.0, 0.0)


@pytest.mark.promise("the link is lost in a velocity block")
def test_a_lost_subscriber_ends_the_drive_at_once_and_zero_comes_first_afterwards(
    sim, real_time, chassis, until
):
    base = sim.graph.nodes["/mobile_base_nodelet_manager"]
    with pytest.raises(ConnectionLost), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012  (the error must come out of the block)
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.1)
        for subscription in [s for s in sim.graph._keep if getattr(s, "topic", "") == "/smooth_cmd_vel"]:
            subscription.close()
        until(lambda: not drive.active)
        drive.set(0.1)
    received: list[float] = []
    again = base.subscriber(
        "/smooth_cmd_vel", "geometry_msgs/Twist", callback=lambda m: received.append(m.linear.x)
    )
    until(lambda: received)
    time.sleep(0.2)
    again.close()
    assert set(received) == {0.0}


def test_a_chassis_that_falls_silent_ends_the_drive_with_zero(sim, real_time, chassis, until):
    with pytest.raises(ConnectionLost, match="silent"), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012  (the error must come out of the block)
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.1)
        sim.fall_silent(3.0)
        drive.hold(0.2, seconds=5.0)
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


def test_a_chassis_that_tells_no_velocity_is_not_driven_blind():
    with SimulatedChassis(full_graph=False) as sim:
        sim.fall_silent(60.0)
        with Chassis(sim.master_uri) as chassis, pytest.raises(StaleState, match="odom_twist"):
            chassis.velocity(bypasses_protection=True).__enter__()


def test_only_one_block_is_open_at_a_time(chassis):
    with (
        chassis.velocity(bypasses_protection=True),
        pytest.raises(MotionRefused, match="another"),
        chassis.velocity(bypasses_protection=True),
    ):
        pass


@pytest.mark.promise("**the program and its watchdog are killed at once")
def test_what_remains_of_a_killed_process_is_the_chassis_own_behaviour(sim, real_time, until):
    publisher_side = Chassis(sim.master_uri)
    drive = publisher_side.velocity(bypasses_protection=True)
    drive.__enter__()
    drive.set(0.2, valid_for=5.0)
    until(lambda: sim.world.body.velocity.vx > 0.1)
    # A killed process sends nothing any more: take its sockets away without any of our own clean-up.
    publisher_side._components.velocity.write_zero = lambda topic: None  # type: ignore[method-assign]
    publisher_side.node.close()
    time.sleep(0.5)
    assert sim.world.body.velocity.vx > 0.1


def test_the_shaper_ramps_up_and_stops_at_once():
    shaper = Shaper(DriveLimits(1.0, 1.0, acceleration=0.5, angular_acceleration=1.0))
    shaper.command(Velocity(0.5), now=0.0, valid_for=1.0)
    assert shaper.next(0.0).vx == pytest.approx(0.025)
    assert shaper.next(0.1).vx == pytest.approx(0.075)
    assert shaper.next(1.5) == Velocity()
    shaper.command(Velocity(0.5), now=2.0, valid_for=1.0)
    shaper.next(2.0)
    shaper.command(Velocity(0.0), now=2.1, valid_for=1.0)
    assert shaper.next(2.1).vx == 0.0


PROGRAM = """
import sys
from woosh_pure import Chassis
chassis = Chassis(sys.argv[1])
if sys.argv[2] == "goal":
    chassis.go_to_mark("B1")
    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1, 10)
else:
    drive = chassis.velocity(bypasses_protection=True)
    drive.__enter__().set(0.2, valid_for=5.0)
    chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1, 10)
print("the program ends")
"""


@pytest.mark.promise("the `Chassis` block is left, or the program ends in an orderly way")
@pytest.mark.parametrize("what", ["goal", "velocity"])
def test_an_orderly_exit_without_with_stops_the_robot_too(sim, real_time, until, what):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    command = [sys.executable, "-c", PROGRAM, sim.master_uri, what]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
    assert result.stdout == "the program ends\n", result.stderr
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
    assert not sim.world.tasks.busy


def test_closing_the_chassis_from_another_thread_ends_the_drive_with_zero(sim, real_time, until):
    chassis = Chassis(sim.master_uri)
    with pytest.raises(MotionRefused, match="closed"), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012
        drive.set(0.2, valid_for=5.0)
        until(lambda: sim.world.body.velocity.vx > 0.1)
        chassis.close()
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


KILLED = """
import sys, time
from woosh_pure import Chassis
chassis = Chassis(sys.argv[1])
with chassis.velocity(bypasses_protection=True) as drive:
    print("driving", flush=True)
    while True:
        drive.hold(0.1, seconds=1.0)
"""


@pytest.mark.parametrize("on_silence", ["keep", "stop"])
def test_after_a_kill_only_the_chassis_own_behaviour_remains(until, on_silence):
    """Nothing of ours can send a zero then. It is not known what a real chassis does; both are simulated."""
    settings = Settings(on_silence=on_silence, silence_seconds=0.5)
    with SimulatedChassis(full_graph=False, settings=settings) as sim:
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
        process = subprocess.Popen([sys.executable, "-c", KILLED, sim.master_uri], env=environment)
        try:
            until(lambda: sim.world.body.velocity.vx > 0.09, 60.0)
        finally:
            process.kill()
            process.wait(10.0)
        if on_silence == "keep":
            time.sleep(1.5)
            assert sim.world.body.velocity.vx > 0.09
        else:
            until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="freezes a process with a POSIX signal")
def test_velocities_that_were_stuck_on_the_way_move_nothing_afterwards(until):
    """The chassis hangs, velocities pile up in the sockets, it goes on: the last thing in the pile is zero."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    command = [sys.executable, "-m", "woosh_pure", "sim", "--port", "0", "--for", "60"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        uri = process.stdout.readline().split()[3].rstrip(",")
        with Chassis(uri) as chassis:
            with pytest.raises(ConnectionLost), chassis.velocity(bypasses_protection=True) as drive:  # noqa: PT012
                drive.set(0.2, valid_for=5.0)
                chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1, 10.0)
                process.send_signal(signal.SIGSTOP)
                drive.hold(0.2, seconds=10.0)
            process.send_signal(signal.SIGCONT)
            chassis.measured_velocity.wait_for(lambda v: v.is_standing(0.0, 0.0))
            for _ in range(10):
                assert chassis.measured_velocity.wait(5.0).is_standing(0.0, 0.0)
    finally:
        process.kill()
        process.wait(10.0)
