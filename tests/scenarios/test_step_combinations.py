"""Every kind of step, combined in one goal, paused in the middle of each, on both kinds of base."""

from __future__ import annotations

import contextlib
import math
import os
import random
import time

import pytest

import rosproto
from tests.support.doors import held, in_thread
from tests.support.robot_pool import RobotPool
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.motion.action_goal import ActionMotion
from woosh_pure.motion.steps import Step
from woosh_pure.sim import Settings
from woosh_pure.sim.body import BodyLimits
from woosh_pure.values.messages import message_type

pytestmark = pytest.mark.whole

ALL = (
    Step.straight(0.4, 0.3),
    Step.turn(math.pi / 2, 0.8),
    Step.lateral(0.4, 0.3),
    Step.diagonal(0.5, math.pi / 4, 0.3),
    Step.turn(-1.0, 0.8),
    Step.straight(-0.8, 0.3),
)


def end_of(steps):
    """Where a list of steps leads, from the origin."""
    pose = Pose2D(0.0, 0.0, 0.0)
    for step in steps:
        d, size = step.direction(), abs(step.data)
        pose = pose.transformed(d.vx * size, d.vy * size, d.wz * size)
    return pose


@pytest.fixture(scope="module")
def omnidirectional():
    settings = Settings(limits=BodyLimits(omnidirectional=True))
    with RobotPool(settings=settings, full_graph=False) as pool:
        yield pool


@pytest.fixture
def omni(omnidirectional):
    robot = omnidirectional.take(8.0)
    yield robot.sim
    omnidirectional.give_back(robot)


def test_all_four_kinds_as_one_goal_on_an_omnidirectional_base(omni):
    with Chassis(omni.master_uri) as chassis:
        handle = chassis.steps(ALL)
        seen = [len(ALL) - len(handle.remaining()) for _ in handle.reports()]
        handle.wait()
    target = end_of(ALL)
    assert omni.pose.distance_to(target) < 0.02
    assert abs(omni.pose.angle_to(target)) < 0.02
    assert seen == sorted(seen)


def hold_in_step(monkeypatch, world, index):
    """The world's time stands in the middle of a step until a pause arrives there."""
    step, pause_step = world.step, world.pause_step
    waiting = True

    def step_unless_there(dt):
        motion = world.motion
        if not (waiting and motion and motion.index == index and motion.percent > 20.0):
            step(dt)

    def note_pause():
        nonlocal waiting
        waiting = False
        return pause_step()

    monkeypatch.setattr(world, "step", step_unless_there)
    monkeypatch.setattr(world, "pause_step", note_pause)


@pytest.mark.parametrize("paused_in", range(len(ALL)))
def test_pausing_in_each_kind_of_step_and_resuming_what_remains(omni, until, monkeypatch, paused_in):
    hold_in_step(monkeypatch, omni.world, paused_in)
    with Chassis(omni.master_uri) as chassis:
        handle = chassis.steps(ALL)
        until(lambda: handle.latest_report and len(handle.remaining()) == len(ALL) - paused_in, 20.0)
        handle.pause()
        before = handle.progress.percent
        chassis.measured_velocity.wait_for(Velocity.is_standing, 5.0)
        assert not handle.done
        handle.resume()
        seen = [(len(ALL) - len(handle.remaining()), handle.progress.percent) for _ in handle.reports()]
        handle.wait(30.0)
    assert omni.pose.distance_to(end_of(ALL)) < 0.03
    assert [index for index, _ in seen] == sorted(index for index, _ in seen)
    assert all(percent >= before - 6.0 for _, percent in seen)  # progress goes on, it does not begin anew


def test_a_pause_that_comes_when_the_move_has_just_ended_says_so(sim, chassis, until, monkeypatch):
    """It was under way when the pause was asked for; the chassis then found nothing to pause. The move arrived."""
    speed, sim.speed = sim.speed, 0.0  # the world's time stands
    handle = chassis.move(0.2)
    with held(monkeypatch, rosproto.ActionClient, "send_goal") as (came, go_on):
        thread, errors = in_thread(handle.pause)
        assert came.wait(10.0)
        sim.speed = speed
        until(lambda: handle._motion._goal.done)
        go_on.set()
        thread.join(10.0)
    assert isinstance(errors[0], MotionRefused)
    assert "has ended" in str(errors[0])
    assert handle.wait().arrived


@pytest.mark.parametrize("sideways", [Step.lateral(0.2), Step.diagonal(0.2, 0.5)])
def test_a_combination_with_a_sideways_step_moves_a_differential_base_not_at_all(sim, chassis, sideways):
    with pytest.raises(GoalFailed) as caught:
        chassis.steps([Step.straight(0.3), sideways]).wait(10.0)
    assert caught.value.outcome.kind is OutcomeKind.FAILED
    assert sim.pose.x == 0.0


def test_pausing_twice_and_cancelling_while_paused(sim, chassis, until):
    handle = chassis.steps([Step.straight(2.0, 0.5), Step.turn(1.0)])
    until(lambda: sim.pose.x > 0.2)
    handle.pause()
    handle.resume()
    until(lambda: handle.latest_report and not sim.world.body.velocity.is_standing(0.05))
    handle.pause()
    chassis.measured_velocity.wait_for(Velocity.is_standing, 5.0)
    assert handle.cancel().kind is OutcomeKind.CANCELLED
    with pytest.raises(MotionRefused, match="has ended"):
        handle.pause()
    held = sim.pose
    assert chassis.rotate(0.2, speed=0.5).wait()
    assert sim.pose.distance_to(held) < 0.02


def test_a_pause_that_comes_while_a_resume_is_being_sent_is_not_forgotten(
    sim, real_time, chassis, until, monkeypatch
):
    """The resume noted "not paused" after the pause had noted "paused": the end by our own pause was told as
    "replaced"."""
    handle = chassis.move(1.0)
    until(lambda: handle.latest_report and handle.latest_report.percent > 5)
    handle.pause()
    send, pausing = handle._motion.send, []

    def sent_then_paused(work):
        send(work)
        pausing.append(in_thread(handle.pause))
        pausing[0][0].join(1.0)

    monkeypatch.setattr(handle._motion, "send", sent_then_paused)
    handle.resume()
    monkeypatch.undo()
    thread, errors = pausing[0]
    thread.join(10.0)
    assert (errors, handle.outcome) == ([], None)
    real_time()
    handle.resume()
    assert handle.wait(30.0).arrived
    assert abs(sim.pose.x - 1.0) < 0.03


def test_an_end_by_our_own_pause_is_never_told_as_replaced_however_late_a_thread_looks(
    sim, chassis, until, monkeypatch
):
    """A thread that looked at the goal went on only after the pause had preempted it."""
    handle = chassis.move(1.0)
    until(lambda: handle.latest_report and handle.latest_report.percent > 5)
    with held(monkeypatch, ActionMotion, "check") as (came, go_on):
        looking, _ = in_thread(lambda: handle.done)
        assert came.wait(10.0)
        monkeypatch.undo()
        handle.pause()
        go_on.set()
        looking.join(10.0)
    assert handle.outcome is None
    handle.resume()
    assert handle.wait(30.0).arrived


def test_feedback_of_a_part_before_the_pause_counts_for_that_part_only(sim, chassis, until, monkeypatch):
    """It may be called back after the rest was sent, on a busy computer."""
    handle = chassis.move(1.0)
    until(lambda: handle.latest_report and handle.latest_report.percent > 5)
    kept, on_feedback = [], handle._motion._on_feedback
    first = handle._motion._goal
    handle.pause()
    handle.resume()
    late = message_type("woosh_msgs/StepControlFeedback")(feedback=1, executeMode=1, percent=60.0)
    before = handle.progress.percent
    on_feedback(first, late)
    kept.append(handle.progress.percent)
    assert kept[0] - before < 10.0
    assert handle.wait(30.0).arrived
    assert abs(sim.pose.x - 1.0) < 0.03


@pytest.mark.slow
def test_pauses_and_resumes_of_several_threads_at_once_lose_nothing(sim, chassis):
    """PAUSE_TRIALS=50 in the environment repeats it so often. Each move arrives after its whole way; a pause or resume that
    is refused says why."""
    chance, failed = random.Random(5), []
    for trial in range(int(os.environ.get("PAUSE_TRIALS", "2"))):
        began, ahead = sim.pose.x, 0.5 if trial % 2 == 0 else -0.5
        handle = chassis.move(ahead)

        def hold_and_go_on(handle=handle):
            for _ in range(2):
                for verb in (handle.pause, handle.resume):
                    time.sleep(chance.uniform(0.0, 0.1))
                    with contextlib.suppress(MotionRefused):
                        verb()

        threads = [in_thread(hold_and_go_on) for _ in range(2)]
        for thread, errors in threads:
            thread.join(60.0)
            assert not errors
        with contextlib.suppress(MotionRefused):
            handle.resume()  # a pause of one thread may have come last
        outcome = handle.wait(30.0, raises=False)
        if not outcome.arrived or abs(sim.pose.x - began - ahead) > 0.05:
            failed.append((trial, str(outcome.kind), outcome.text, round(sim.pose.x - began, 3)))
    assert not failed


def test_resuming_what_was_not_paused_is_refused(chassis):
    handle = chassis.move(0.2)
    with pytest.raises(MotionRefused, match="not paused"):
        handle.resume()
    handle.wait()
