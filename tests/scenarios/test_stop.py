"""`stop()` beside what is missing, what is slow, and other programs that drive."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

import rosproto
from msgdefs.geometry_msgs.msg import Twist
from rosproto.errors import RosError
from rosproto.protocol.goal_server import GoalList, GoalRecord
from tests.scenarios.test_sharing import TWIST
from woosh_pure import Chassis, OutcomeKind
from woosh_pure.cli import main

FOR_EVER = 60.0
"""Seconds that no test may take: what is not there is not waited for."""


def test_without_a_chassis_a_stop_says_at_once_that_nobody_is_there():
    with rosproto.Master() as master, Chassis(master.uri) as chassis:
        report = chassis.stop(everything=True, timeout=FOR_EVER)
    assert report.standing is None
    assert report.cancelled == []
    (problem,) = report.problems
    for name in ("/base_cmd_vel", "/cmd_vel_control", "/exec_task", "/move_base,", "/odom_twist", master.uri):
        assert name in problem


def test_so_does_the_command(capsys):
    with rosproto.Master() as master:
        assert main(["stop", "--master", master.uri, "--timeout", str(FOR_EVER)]) == 1
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert "watch it; not done: no node provides" in out


def test_what_is_there_of_a_broken_chassis_is_stopped():
    """Its navigation has crashed, and so has what measures: the rest is told, and the master has forgotten nobody."""
    with rosproto.Master() as master, rosproto.Node("/half", master_uri=master.uri) as half:
        velocities, cancels = threading.Event(), threading.Event()
        half.subscriber("/smooth_cmd_vel", TWIST, callback=lambda _: velocities.set())
        half.subscriber("/move_base/cancel", "actionlib_msgs/GoalID", callback=lambda _: cancels.set())
        with Chassis(master.uri) as chassis:
            report = chassis.stop(everything=True, timeout=FOR_EVER)
            assert velocities.wait(5.0)
            assert cancels.wait(5.0)
    assert report.cancelled == ["all goals of /move_base"]
    assert "/base_cmd_vel, /cmd_vel_control, /exec_task, /odom_twist" in report.problems[0]


@pytest.mark.promise("`chassis.stop(everything=True)`, `woosh stop`")
def test_goals_and_tasks_of_others_are_cancelled(sim, chassis, until):
    chassis.wait_until_ready()
    with Chassis(sim.master_uri, name="other") as other:
        goal = other.go_to(2.5, 0.0)
        until(lambda: sim.world.motion is not None)
        assert chassis.stop(everything=True, timeout=FOR_EVER).standing
        assert goal.wait(10.0, raises=False).kind is OutcomeKind.REPLACED
        task = other.go_to_mark("A1")
        chassis.status.wait_for(lambda status: status.task_id == task.task_id, 10.0)
        report = chassis.stop(everything=True, timeout=FOR_EVER)
        assert f"task {task.task_id}" in report.cancelled
        assert task.wait(10.0, raises=False).kind is OutcomeKind.CANCELLED


def test_a_cancel_that_is_lost_is_sent_again(sim, chassis, until, monkeypatch):
    """As when the robot ends the connection before it has read the cancel."""
    came: list[str] = []
    heard = GoalList.cancel_received

    def lose_the_first(goals: GoalList, id: str, stamp: int, now: float) -> list[GoalRecord]:
        came.append(id)
        return heard(goals, id, stamp, now) if id else []

    chassis.wait_until_ready()
    with Chassis(sim.master_uri, name="other") as other:
        goal = other.rotate(60.0, several_turns=True)
        until(lambda: sim.world.motion is not None)
        monkeypatch.setattr(GoalList, "cancel_received", lose_the_first)
        report = chassis.stop(everything=True, timeout=FOR_EVER)
        assert report.standing
        assert "all goals of /cmd_vel_control" in report.cancelled
        assert "" in came
        assert goal.wait(10.0, raises=False).kind is OutcomeKind.REPLACED


def test_a_goal_that_ignores_its_cancel_is_named(sim, chassis, until, monkeypatch):
    chassis.wait_until_ready()
    with Chassis(sim.master_uri, name="other") as other:
        other.rotate(60.0, several_turns=True)
        until(lambda: sim.world.motion is not None)
        with monkeypatch.context() as deaf:
            deaf.setattr(GoalList, "cancel_received", lambda *cancel: [])
            report = chassis.stop(everything=True, timeout=1.0)
        assert report.standing is False
        assert "cancelling /cmd_vel_control (it goes on)" in report.problems
        chassis.stop(everything=True, timeout=FOR_EVER)


@pytest.mark.promise("Ctrl-C in `handle.wait()`")
@pytest.mark.parametrize("leave", [False, True], ids=["", "leave_running"])
def test_ctrl_c_in_a_wait_cancels_the_goal_although_no_block_is_left(sim, until, leave):
    """In a notebook the robot would drive on, and `chassis.go_to(...).wait()` leaves nobody a handle."""

    def ctrl_c() -> None:
        raise KeyboardInterrupt

    chassis = Chassis(sim.master_uri, leave_running=leave)
    with pytest.raises(KeyboardInterrupt):
        chassis.go_to(2.5, 0.0).wait(meanwhile=ctrl_c)
    if leave:
        assert chassis.under_way
    else:
        assert "cancelled navigation to x 2.500 m" in chassis.stop(timeout=FOR_EVER).sentence()
        until(lambda: sim.world.motion is None)
    chassis.close()


@contextmanager
def slow_driver(uri: str) -> Iterator[None]:
    """A program that sends a velocity now and then, with time between them for a robot to stop."""
    over = threading.Event()
    forward = Twist()
    forward.linear.x = 0.03
    with rosproto.Node("/slow_driver", master_uri=uri) as node, node.publisher("/base_cmd_vel", TWIST) as out:

        def drive() -> None:
            out.publish(forward)
            while not over.wait(0.6):
                out.publish(forward)

        out.wait_for_connection()
        thread = threading.Thread(target=drive)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()


def test_a_robot_that_stands_between_two_velocities_of_another_program_does_not_stand(sim, chassis, until):
    with slow_driver(chassis.node.master_uri):
        until(lambda: not sim.world.body.velocity.is_standing())
        report = chassis.stop(everything=True, timeout=3.0)
    assert report.standing is False
    (problem,) = [problem for problem in report.problems if "/slow_driver" in problem]
    assert re.search(
        "also sends? velocities on /base_cmd_vel, which stops only when that program ends", problem
    )


def test_at_rest_it_says_that_nothing_ran(sim, chassis):
    """It asks five action servers to cancel; none had a goal."""
    chassis.wait_until_ready()
    report = chassis.stop(everything=True, timeout=FOR_EVER)
    assert report.cancelled == []
    assert report.sentence() == "the robot stands still; nothing was running"
    assert chassis.stop().sentence() == "the robot stands still; nothing of this program was running"


@pytest.mark.parametrize("slow", [False, True], ids=["", "slow network"])
def test_what_ran_is_named_and_what_did_not_is_not(sim, real_time, chassis, until, slow):
    chassis.wait_until_ready()
    with Chassis(chassis.node.master_uri, name="other") as other:
        other.go_to(2.5, 0.0)
        until(lambda: sim.world.motion is not None)
        sim.slow_network(0.2 if slow else 0.0)
        report = chassis.stop(everything=True, timeout=FOR_EVER)
        sim.slow_network(0.0)
    assert report.cancelled == ["all goals of /move_base"]


@pytest.mark.promise("`chassis.stop(end_drivers=True)`")
def test_programs_that_drive_are_asked_to_end_and_zero_follows(sim, chassis, until):
    with Chassis(chassis.node.master_uri, name="driver") as other:
        block = other.velocity(bypasses_protection=True)
        with pytest.raises(RosError), block as drive:  # noqa: PT012
            drive.set(0.05, valid_for=5.0)
            until(lambda: not sim.world.body.velocity.is_standing())
            report = chassis.stop(end_drivers=True, timeout=FOR_EVER)
            drive.hold(0.05, seconds=5.0)
    assert report.standing is True
    assert report.problems == []
    (ended,) = report.cancelled
    assert ended.startswith("the program /driver")


def test_a_program_that_refuses_to_end_is_named(sim, chassis):
    with (
        rosproto.Node("/stubborn", master_uri=chassis.node.master_uri, allow_shutdown=False) as node,
        node.publisher("/smooth_cmd_vel", TWIST),
    ):
        report = chassis.stop(end_drivers=True, timeout=1.5)
    (problem,) = [problem for problem in report.problems if "/stubborn" in problem]
    assert "it was asked to end and has not" in problem
