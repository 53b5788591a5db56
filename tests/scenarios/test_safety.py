"""What must stop the robot, or keep it from starting, when a program, its user, its computer or the chassis goes away."""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import signal
import sys
import threading
import time
from functools import partial
from types import FrameType
from typing import Any

import pytest

import rosproto
from rosproto.errors import ConnectionLost, RosTimeout
from tests.scenarios.test_ends_of_programs import program, start
from tests.support.doors import held, in_thread
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, SimulatedChassis
from woosh_pure.enums import RobotState
from woosh_pure.readiness.readiness_state import ReadinessState
from woosh_pure.reasons import Ready
from woosh_pure.values.messages import message_type
from woosh_pure.velocity import end_conditions

# -- a stop meets what is just beginning -----------------------------------------------------------------------


@pytest.mark.promise("`chassis.stop()`, from any thread")
@pytest.mark.parametrize("door", ["wait_for_server", "send_goal"], ids=["being prepared", "being sent"])
def test_a_stop_also_stops_the_goal_that_another_thread_is_just_about_to_send(
    sim, chassis, monkeypatch, door
):
    chassis.readiness()
    sim.speed = 0.1  # it does not get far meanwhile
    with held(monkeypatch, rosproto.ActionClient, door) as (came, go_on):
        thread, errors = in_thread(lambda: chassis.go_to(2.5, 0.0))
        assert came.wait(10.0)
        stopping, _ = in_thread(lambda: chassis.stop(timeout=2.0))
        until_noted(chassis)
        if door == "send_goal":
            assert wait_for(lambda: all(goal.asked for goal in chassis._components.motions.goals))
        go_on.set()
        thread.join(10.0)
        stopping.join(10.0)
    assert door == "send_goal" or isinstance(errors[0], MotionRefused)
    assert wait_for(lambda: not chassis._components.motions.goals)
    assert wait_for(lambda: sim.world.motion is None)
    assert abs(sim.pose.x) < 0.3


def until_noted(chassis: Chassis) -> None:
    assert wait_for(lambda: chassis._components.motions.stops == 1)


def wait_for(condition: Any, timeout: float = 10.0) -> bool:
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def test_a_stop_keeps_a_velocity_block_from_opening_that_is_just_being_opened(sim, chassis, monkeypatch):
    block = chassis.velocity(bypasses_protection=True)
    with held(monkeypatch, rosproto.Publisher, "wait_for_connection") as (came, go_on):
        thread, errors = in_thread(block.__enter__)
        assert came.wait(10.0)
        assert chassis.stop(timeout=2.0).problems == []
        go_on.set()
        thread.join(10.0)
    assert isinstance(errors[0], MotionRefused)
    assert "stop() was called" in str(errors[0])
    with pytest.raises(MotionRefused):
        block.set(0.1)


@pytest.mark.promise("a stop while a motion is being prepared")
@pytest.mark.parametrize(
    "begin",
    [
        lambda chassis: chassis.go_to_mark("A1"),
        lambda chassis: chassis.go_to(2.5, 0.0),
        lambda chassis: chassis.move(0.5),
        lambda chassis: chassis.velocity(bypasses_protection=True).__enter__(),
    ],
    ids=["task", "navigation", "steps", "velocity"],
)
def test_what_was_requested_before_a_stop_does_not_begin_after_it(sim, chassis, begin):
    """However long the thread that is to begin it waited; what is requested afterwards begins."""
    request = chassis.request()
    chassis.stop(timeout=2.0)
    with request, pytest.raises(MotionRefused, match="stop\\(\\) was called"):
        begin(chassis)
    assert sim.world.motion is None
    with chassis.request():
        chassis.move(0.05).wait(20)


def test_a_stop_within_a_request_is_a_part_of_it(chassis):
    """What the same call begins afterwards moves, unless somebody else has stopped the robot, too."""
    request = chassis.request()
    with request:
        chassis.stop(timeout=2.0)
        assert not request.overtaken
        chassis.move(0.05).wait(20)
    chassis.stop(timeout=2.0)
    with request:
        chassis.stop(timeout=2.0)
        with pytest.raises(MotionRefused, match="stop\\(\\) was called"):
            chassis.move(0.05)
    assert request.overtaken
    assert not request.renewed().overtaken


def test_a_velocity_block_that_was_made_before_a_stop_does_not_open_after_it(chassis):
    block = chassis.velocity(bypasses_protection=True)
    chassis.stop(timeout=2.0)
    with pytest.raises(MotionRefused, match="stop\\(\\) was called"), block:
        pass
    with chassis.velocity(bypasses_protection=True) as drive:
        assert drive.active


def test_an_awaited_verb_that_waits_for_a_thread_does_not_begin_after_a_stop(sim, chassis):
    """All threads of the asyncio face are in use when it is awaited."""
    busy, waiting = threading.Event(), []

    async def main() -> None:
        robot = chassis.aio
        calls = robot._calls
        others = [asyncio.create_task(calls.call(lambda: busy.wait(20))) for _ in range(64)]
        await asyncio.sleep(0)
        waiting.append(asyncio.create_task(robot.go_to_mark("A1").start()))
        await asyncio.sleep(0.1)
        await robot.stop(timeout=2.0)
        busy.set()
        await asyncio.gather(*others)
        with pytest.raises(MotionRefused, match="stop\\(\\) was called"):
            await waiting[0]

    asyncio.run(main())
    assert sim.world.motion is None


@pytest.mark.parametrize("when", ["while its message waits", "while speed and direction are set"])
def test_a_drive_of_an_order_that_is_being_prepared_does_not_begin_after_a_stop(
    sim, chassis, monkeypatch, when
):
    from woosh_pure.fleet.drive_runner import DriveRunner
    from woosh_pure.fleet.messages.elements import Node, NodePosition
    from woosh_pure.fleet.order.events import Drive

    ended: list[Any] = []
    runner = DriveRunner(chassis, ended.append, lambda: None)
    drive = Drive(1, Node("b", 2, True, NodePosition(2.0, 0.0, "hall", 0.0)), None)
    request = chassis.request()  # as the vehicle does when the message comes
    with held(monkeypatch, Chassis, "set_navigation_mode") as (came, go_on):
        if when == "while its message waits":
            chassis.stop(timeout=2.0)
        with request:
            runner.drive(drive)
        assert came.wait(10.0)
        if when != "while its message waits":
            chassis.stop(timeout=2.0)
        go_on.set()
        assert wait_for(lambda: ended)
    assert (ended[0].arrived, ended[0].known) == (False, True)
    assert "stop() was called" in ended[0].text
    assert sim.world.motion is None


def test_a_resume_that_a_stop_overtakes_does_not_move(sim, real_time, chassis, until, monkeypatch):
    handle = chassis.move(2.0)
    until(lambda: handle.latest_report and handle.latest_report.percent > 5)
    handle.pause()
    until(lambda: sim.world.body.velocity.is_standing())
    with held(monkeypatch, rosproto.ActionClient, "send_goal") as (came, go_on):
        thread, _ = in_thread(handle.resume)
        assert came.wait(10.0)
        stopping, _ = in_thread(lambda: chassis.stop(timeout=2.0))
        assert wait_for(lambda: handle._motion.asked)
        go_on.set()
        thread.join(10.0)
        stopping.join(10.0)
    assert wait_for(lambda: sim.world.motion is None and sim.world.body.velocity.is_standing())
    assert handle.outcome.kind is OutcomeKind.CANCELLED


# -- the user goes away ----------------------------------------------------------------------------------------


def test_ctrl_c_while_a_goal_is_being_sent_cancels_it_without_leaving_a_block(
    sim, chassis, until, monkeypatch
):
    """In a notebook nobody leaves a block, and nobody has the handle of a call that was interrupted."""
    real_is_alive = threading.Thread.is_alive

    def interrupted(thread: threading.Thread) -> bool:
        if thread.name == "woosh:send" and threading.current_thread() is threading.main_thread():
            monkeypatch.undo()
            thread.join(0.1)
            raise KeyboardInterrupt
        return real_is_alive(thread)

    monkeypatch.setattr(threading.Thread, "is_alive", interrupted)
    with pytest.raises(KeyboardInterrupt):
        chassis.go_to(2.5, 0.0)
    until(lambda: not chassis._components.motions.goals)
    until(lambda: sim.world.motion is None and sim.world.body.velocity.is_standing())
    assert sim.pose.x < 2.0


class Interrupter:
    """Raises KeyboardInterrupt at one line of the library, as a second Ctrl-C does while blocks are being left."""

    def __init__(self, line: int) -> None:
        self.left = line

    def __call__(self, frame: FrameType, event: str, argument: object) -> Any:
        name = frame.f_code.co_filename
        if "woosh_pure" not in name or f"{os.sep}sim{os.sep}" in name:
            return None
        if event == "line":
            self.left -= 1
            if self.left == 0:
                sys.settrace(None)
                raise KeyboardInterrupt("the second one")
        return self


class AtExit:
    """Stands for the module: what the interpreter would call at its end."""

    def __init__(self) -> None:
        self.calls: list[Any] = []

    def register(self, call: Any) -> None:
        self.calls.append(call)

    def unregister(self, call: Any) -> None:
        self.calls = [other for other in self.calls if other != call]


@pytest.mark.promise("Ctrl-C again and again")
@pytest.mark.skipif(sys.gettrace() is not None, reason="a debugger or coverage has the trace function")
@pytest.mark.parametrize("what", ["velocity", "goal"])
@pytest.mark.parametrize("line", [1, 4, 9, 16, 25, 40, 60, 85])
def test_a_second_ctrl_c_while_the_blocks_are_left_stops_the_robot_all_the_same(
    sim, until, monkeypatch, what, line
):
    """At whatever line it comes: the end of the program does what was left undone. (Every line was tried by hand.)"""
    at_exit = AtExit()
    monkeypatch.setattr("woosh_pure.stopping.active_motions.atexit", at_exit)
    chassis = Chassis(sim.master_uri)
    before = sys.gettrace()
    try:
        with pytest.raises(KeyboardInterrupt), chassis:  # noqa: PT012
            chassis.measured_velocity.wait(5.0)
            with contextlib.ExitStack() as stack:
                if what == "velocity":
                    drive = stack.enter_context(chassis.velocity(bypasses_protection=True))
                    drive.set(0.05, valid_for=5.0)
                else:
                    chassis.go_to(2.5, 0.0)
                until(lambda: not sim.world.body.velocity.is_standing())
                sys.settrace(Interrupter(line))
                raise KeyboardInterrupt("the first one")
    finally:
        sys.settrace(before)
        for call in reversed(at_exit.calls):
            call()
    until(lambda: sim.world.motion is None and sim.world.body.velocity.is_standing(0.0, 0.0))
    with contextlib.suppress(ConnectionLost):
        chassis.close()


# -- the computer stops, sleeps, sets its clock ----------------------------------------------------------------


@pytest.mark.promise("the program was stopped for more than a second")
@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals to a process")
def test_a_drive_does_not_go_on_after_its_program_was_stopped(sim, until):
    """SIGSTOP, Ctrl-Z, a debugger that holds every thread: who drove does not know where the robot is now."""
    body = (
        "try:\n        with chassis.velocity(bypasses_protection=True, feedback_timeout=None) as drive:\n"
        "            drive.set(0.05, valid_for=5.0)\n            print('waiting', flush=True)\n"
        "            drive.hold(0.05, seconds=999)\n"
        "    except MotionRefused as error:\n        print(error, flush=True)"
    )
    process = start(program(body), sim.master_uri)
    try:
        assert process.stdout.readline() == "waiting\n"
        until(lambda: not sim.world.body.velocity.is_standing())
        process.send_signal(signal.SIGSTOP)
        time.sleep(1.5)  # the pause itself
        assert not sim.world.body.velocity.is_standing()  # as after a kill: nothing of ours runs
        process.send_signal(signal.SIGCONT)
        assert "did not run for" in process.stdout.readline()
        until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))
    finally:
        process.kill()
        process.communicate()


LISTENER = """
import sys, threading, rosproto
with rosproto.Node("/listener", master_uri=sys.argv[1]) as node:
    node.subscriber("/smooth_cmd_vel", "geometry_msgs/Twist", callback=print)
    print("up", flush=True)
    threading.Event().wait()
"""


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals to a process")
def test_a_drive_without_feedback_ends_when_who_listens_does_not_answer():
    """The link lives on: what is sent is kept by TCP, and would be obeyed late."""
    with rosproto.Master() as master, Chassis(master.uri) as chassis:
        listener = start(LISTENER, master.uri)
        try:
            assert listener.stdout.readline() == "up\n"
            with chassis.velocity(bypasses_protection=True, feedback_timeout=None) as drive:
                drive.hold(0.1, seconds=0.5)
                listener.send_signal(signal.SIGSTOP)
                with pytest.raises(ConnectionLost, match="has not answered within 1 s"):
                    drive.hold(0.1, seconds=20.0)
        finally:
            listener.kill()
            listener.communicate()


def test_a_drive_without_feedback_says_when_nobody_can_be_asked(sim, chassis, monkeypatch, caplog):
    """A firewall in front of the robot's nodes is no reason not to drive, but there is no guard then."""

    def silent(client, *, timeout=None):
        raise RosTimeout("no answer", what="getPid", seconds=timeout)

    monkeypatch.setattr("rosproto.node.NodeClient.get_pid", silent)
    with chassis.velocity(bypasses_protection=True, feedback_timeout=None) as drive:
        drive.hold(0.1, seconds=0.2)
    assert "nothing ends this drive when the network delivers late" in caplog.text


def test_a_laptop_that_slept_ends_its_drive(sim, chassis, until, monkeypatch):
    """time.monotonic() stands still in sleep, so that the last command would be fresh; the watch's clock does not."""
    slept = [0.0]
    seconds = end_conditions.boot_seconds
    monkeypatch.setattr(end_conditions, "boot_seconds", lambda: seconds() + slept[0])
    with (  # noqa: PT012
        chassis.velocity(bypasses_protection=True) as drive,
        pytest.raises(MotionRefused, match="not run for"),
    ):
        drive.set(0.05, valid_for=5.0)
        slept[0] = 3600.0
        drive.hold(0.05, seconds=20.0)
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


@pytest.mark.parametrize("jump", [-86400.0, 86400.0])
def test_a_clock_that_is_set_changes_nothing(sim, chassis, monkeypatch, jump):
    """No wait and no lapse looks at the wall: an hour that NTP takes back must not let a velocity live longer."""
    real = time.time
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.05, valid_for=1.0)
        monkeypatch.setattr(time, "time", lambda: real() + jump)
        assert wait_for(lambda: not sim.world.body.velocity.is_standing(0.0, 0.0))
        assert wait_for(lambda: drive.sending.is_standing(0.0, 0.0))
        assert drive.active
    assert chassis.go_to(0.3, 0.0).wait(20.0)


def test_the_watch_uses_a_clock_that_counts_sleep_where_the_system_has_one():
    assert end_conditions.boot_seconds() == pytest.approx(end_conditions.boot_seconds(), abs=1.0)
    if sys.platform == "linux":
        assert end_conditions._SOURCE == time.CLOCK_BOOTTIME


# -- the emergency stop ----------------------------------------------------------------------------------------


@pytest.mark.promise("the robot stands for 3 s")
def test_a_robot_that_stands_although_it_is_told_to_move_ends_the_drive(sim, until, monkeypatch):
    """An emergency stop that was pressed before we came is told to nobody: releasing it must not let the robot start."""
    monkeypatch.setattr("woosh_pure.velocity.end_conditions.DISOBEYED_SECONDS", 0.5)
    sim.press_emergency_stop()
    until(lambda: not sim.world._reports)
    with Chassis(sim.master_uri) as chassis:
        assert chassis.readiness().answer is Ready.UNKNOWN  # nobody has told
        with chassis.velocity(bypasses_protection=True) as drive:
            with pytest.raises(MotionRefused, match=r"stood still.*emergency stop"):
                drive.hold(0.1, seconds=20.0)
            until(lambda: sim.world._active_command().is_standing(0.0, 0.0))  # the zero is on its way
            sim.release_emergency_stop()
            chassis.measured_velocity.wait(5.0)
            assert sim.world.body.velocity.is_standing(0.0, 0.0)
            assert not drive.active


def test_a_drive_that_asks_for_nothing_may_stand(sim, chassis, monkeypatch):
    monkeypatch.setattr("woosh_pure.velocity.end_conditions.DISOBEYED_SECONDS", 0.1)
    with chassis.velocity(bypasses_protection=True) as drive:
        for _ in range(5):
            drive.set(0.0)
            chassis.measured_velocity.wait(5.0)
        assert drive.active


# -- wrong numbers ---------------------------------------------------------------------------------------------


def test_limits_of_the_chassis_that_cannot_be_meant_leave_the_careful_ones(sim, chassis):
    """A firmware that says mm/s, or the largest number it knows, must not let 100 m/s pass."""
    publisher = sim.graph.first("/driver_base/parameter")
    parameters = publisher.message_class(maxLinear=1500.0, maxAngular=1e30)
    chassis.parameters.wait(5.0)
    sim.fall_silent(60.0)
    with sim.lock:
        for _ in range(2):  # what was being published has been
            sim.lock.wait(10.0)
    publisher.publish(parameters)
    chassis.parameters.wait_for(lambda p: p.max_linear == 1500.0)
    limits = chassis.velocity(bypasses_protection=True).limits
    assert (limits.linear, limits.angular) == (0.3, 0.5)


def goal(kind: str, **fields: Any) -> Any:
    return message_type(f"woosh_msgs/{kind}Goal")(**fields)


def test_numbers_are_checked_in_messages_of_ones_own_too(sim, chassis):
    step = message_type("woosh_msgs/StepControl")
    target = message_type("geometry_msgs/PoseStamped")()
    target.pose.position.x = math.nan
    polygon = message_type("geometry_msgs/Polygon")(
        points=[message_type("geometry_msgs/Point32")(x=math.inf)]
    )
    for call, words in (
        (lambda: chassis.action("/move_base", goal("MoveBase", target_pose=target)), r"target_pose.*position\.x"),
        (lambda: chassis.action("/cmd_vel_control", goal("StepControl", mode=1, stepControl=[step(executeMode=1, data=500.0)])), "10.0 m"),
        (lambda: chassis.send("/move_base/local_costmap/set_footprint", polygon), r"points\[0\]\.x"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=words):
            call()
    assert not chassis.moved


def test_a_goal_of_ones_own_that_drives_the_robot_is_one_like_the_others(sim, chassis, until):
    with chassis.velocity(bypasses_protection=True), pytest.raises(MotionRefused, match="velocity block"):
        chassis.action("/woosh_auto_dock", goal("AutoDock2"))
    handle = chassis.action("/woosh_auto_dock", goal("AutoDock2"))
    with pytest.raises(MotionRefused, match="under way"), chassis.velocity(bypasses_protection=True):
        pass
    handle.cancel()
    sim.press_emergency_stop()
    until(lambda: chassis.readiness().answer is Ready.NO)
    with pytest.raises(MotionRefused, match="emergency stop"):
        chassis.action("/woosh_auto_dock", goal("AutoDock2"))


@pytest.mark.parametrize("what", ["goal", "velocity"])
def test_the_emergency_stop_is_named_although_its_code_comes_after_the_state(sim, chassis, monkeypatch, what):
    """State and code come on two topics: the weaker sentence ("the robot reports a fault") waits for the code."""
    with (
        held(monkeypatch, ReadinessState, "_on_status_code") as (came, go_on),
        contextlib.ExitStack() as stack,
    ):
        chassis.wait_until_ready()
        late = threading.Timer(0.1, go_on.set)
        stack.callback(late.join)
        stack.callback(go_on.set)
        begin = partial(chassis.go_to, 1.0, 0.0)
        if what == "velocity":
            drive = chassis.velocity(bypasses_protection=True).__enter__()
            drive.set(0.1, valid_for=5.0)
            begin = partial(drive.hold, 0.1, seconds=10.0)
        sim.press_emergency_stop()
        assert came.wait(10.0)
        chassis.status.wait_for(lambda s: s.robot_state is RobotState.FAULT, 10.0)
        late.start()
        with pytest.raises(MotionRefused, match="emergency stop"):
            begin()
    sim.release_emergency_stop()


# -- the chassis goes away -------------------------------------------------------------------------------------


ROBOT = """
import sys, time
from woosh_pure import SimulatedChassis
SimulatedChassis(master_uri=sys.argv[1], full_graph=False).start()
print("up", flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize("what", ["goal", "task", "velocity"])
def test_a_chassis_that_dies_is_an_error_within_seconds(until, monkeypatch, what):
    """Killed: no result, no goodbye; its master lives on, and still names its nodes."""
    monkeypatch.setattr("woosh_pure.feed.feed._LOST_AFTER", 0.5)
    with rosproto.Master() as master:
        robot = start(ROBOT, master.uri)
        try:
            assert robot.stdout.readline() == "up\n"
            chassis = Chassis(master.uri, timeout=10.0)
            with contextlib.ExitStack() as stack:
                if what == "velocity":
                    drive = stack.enter_context(chassis.velocity(bypasses_protection=True))
                    drive.set(0.1, valid_for=5.0)
                else:
                    handle = chassis.go_to(2.5, 0.0) if what == "goal" else chassis.go_to_mark("B1")
                    chassis._components.clients.action("/move_base")._goals._status_timeout = 0.5
                chassis.measured_velocity.wait_for(lambda v: not v.is_standing(), 10.0)
                robot.kill()
                if what == "velocity":
                    with pytest.raises(ConnectionLost, match="does not resume by itself"):
                        drive.hold(0.1, seconds=20.0)
                else:
                    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CONNECTION_LOST
            monkeypatch.setattr(chassis._components.connection, "timeout", 0.2)
            with contextlib.suppress(ConnectionLost):
                chassis.close()
        finally:
            robot.kill()
            robot.communicate()


def test_a_chassis_that_restarts_in_the_middle_of_a_task_ends_it(until, monkeypatch):
    """It comes back soon and is idle; nobody there knows the task that we wait for."""
    monkeypatch.setattr("woosh_pure.feed.feed._LOST_AFTER", 60.0)  # soon, on a busy computer, too
    with contextlib.ExitStack() as stack:
        master = stack.enter_context(rosproto.Master())
        first = SimulatedChassis(master_uri=master.uri, full_graph=False).start()
        chassis = Chassis(master.uri)
        handle = chassis.go_to_mark("B1")
        until(lambda: not first.world.body.velocity.is_standing())
        first.close()
        second = stack.enter_context(SimulatedChassis(master_uri=master.uri, full_graph=False))
        stack.enter_context(chassis)
        with pytest.raises(GoalFailed, match=r"restarted|no longer|no task") as caught:
            handle.wait(60.0)
        assert not caught.value.outcome.arrived
        assert not second.world.tasks.busy


def test_a_paused_move_is_lost_with_its_chassis(sim, real_time, chassis, until, monkeypatch):
    """The goal of a paused move has ended; only the chassis itself can tell that there is nothing left to resume."""
    monkeypatch.setattr("woosh_pure.feed.feed._LOST_AFTER", 2.0)
    handle = chassis.move(2.0)
    until(lambda: handle.latest_report and handle.latest_report.percent > 5)
    handle.pause()
    chassis.measured_velocity.wait(5.0)
    assert not handle.done
    sim.fall_silent(30.0)
    assert handle.wait(20.0, raises=False).kind is OutcomeKind.CONNECTION_LOST


def test_a_cancel_that_is_not_answered_is_repeated_by_stop_and_by_close(until):
    with SimulatedChassis(full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        handle = chassis.go_to(2.8, 0.0)
        assert "running" in repr(handle)
        until(lambda: not sim.world.body.velocity.is_standing())
        with pytest.MonkeyPatch.context() as patch:
            for way in ("cancel", "cancel_at_once"):  # the message is lost on its way
                patch.setattr(type(handle._motion._goal), way, lambda _: True)
            patch.setattr(chassis._components.feeds, "wait_standing", lambda timeout: False)
            outcome = handle.cancel(0.2)
        assert outcome.kind is OutcomeKind.CANCELLED
        assert "not confirmed" in outcome.text
        assert "STILL MOVING" in outcome.sentence()
        assert "cancelled" in repr(handle)
        assert sim.world.motion is not None
        assert chassis.stop(timeout=2.0).problems == []
        assert chassis._components.motions.goals == []
        until(lambda: sim.world.motion is None)


# -- asyncio ---------------------------------------------------------------------------------------------------


def test_a_cancelled_task_of_asyncio_stops_what_it_drives(sim, chassis, until):
    async def patrol() -> None:
        with chassis.velocity(bypasses_protection=True) as drive:
            while True:
                drive.set(0.1)
                await asyncio.sleep(0.05)

    async def main() -> None:
        task = asyncio.create_task(patrol())
        while sim.world.body.velocity.is_standing():
            await asyncio.sleep(0.01)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(main())
    until(lambda: sim.world.body.velocity.is_standing(0.0, 0.0))


def test_a_task_of_asyncio_that_awaits_a_goal_takes_it_along_when_it_is_cancelled(sim, chassis, until):
    async def main() -> None:
        assert await chassis.move(0.1)
        task = asyncio.create_task(waiting())
        while sim.world.body.velocity.is_standing():
            await asyncio.sleep(0.01)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        with pytest.raises(GoalFailed):
            await chassis.go_to(50.0, 0.0)

    async def waiting() -> None:
        await chassis.go_to(2.8, 0.0)

    asyncio.run(main())
    until(lambda: sim.world.motion is None and not chassis._components.motions.goals)
    assert sim.pose.x < 2.5
