"""`handle.on_done`: programs with an event loop are told how a goal has ended."""

from __future__ import annotations

import asyncio
import logging
import queue
import threading

import pytest

from woosh_pure import Chassis, Outcome, OutcomeKind


@pytest.fixture
def told() -> queue.SimpleQueue[Outcome]:
    return queue.SimpleQueue()


def test_it_is_called_once_in_its_own_thread_and_at_once_when_it_has_ended(chassis, told, until) -> None:
    handle = chassis.forward(0.3)
    names: list[str] = []
    handle.on_done(lambda outcome: (names.append(threading.current_thread().name), told.put(outcome)))
    outcome = handle.wait(20.0)
    assert told.get(timeout=5.0) == outcome
    handle.on_done(told.put)
    assert told.get(timeout=5.0) == outcome
    until(lambda: all(thread.name != "woosh:done" for thread in threading.enumerate()))
    assert told.empty()
    assert names == ["woosh:done"]


@pytest.mark.parametrize("verb", ["go_to_mark", "go_to", "forward"])
def test_it_says_how_a_goal_ended_that_the_robot_ended(sim, real_time, chassis, told, verb) -> None:
    """An outcome that is not an arrival says whether the robot stands still, as that of `wait` does."""
    begin = {
        "go_to_mark": lambda: chassis.go_to_mark("B1"),
        "go_to": lambda: chassis.go_to(5.5, 2.5),
        "forward": lambda: chassis.forward(3.0),
    }
    begin[verb]().on_done(told.put)
    sim.press_emergency_stop()
    outcome = told.get(timeout=10.0)
    assert outcome.kind is OutcomeKind.FAILED
    assert outcome.stopped


def test_an_exception_in_it_is_logged_and_others_are_still_called(chassis, told, caplog, until) -> None:
    handle = chassis.left(20)
    handle.on_done(lambda outcome: 1 / 0)
    handle.on_done(told.put)
    assert told.get(timeout=20.0).arrived
    until(lambda: "ZeroDivisionError" in caplog.text)
    assert caplog.records[-1].levelno == logging.ERROR


def test_a_callback_that_does_not_return_delays_no_stop(sim, real_time, chassis) -> None:
    """Its thread is its own: neither the one that receives nor the one that stops."""
    held = threading.Event()
    try:
        for verb in (
            lambda: chassis.forward(0.05),
            lambda: chassis.go_to_mark("B1"),
            lambda: chassis.go_to(5.5, 2.5),
        ):
            handle = verb()
            handle.on_done(lambda outcome: held.wait(60.0))
            report = chassis.stop()
            assert report.standing, report
            assert handle.done
    finally:
        held.set()


def test_it_may_call_verbs(chassis, told) -> None:
    """The next motion, and waiting for it."""
    chassis.right(10).on_done(lambda _: told.put(chassis.forward(0.1).wait(20.0)))
    assert told.get(timeout=20.0).arrived


@pytest.mark.parametrize("mark", [True, False])
@pytest.mark.parametrize("leave", [True, False])
def test_it_is_called_when_the_chassis_is_closed(sim, told, mark, leave) -> None:
    """Cancelled, or left running: then its end is not known."""
    with Chassis(sim.master_uri, leave_running=leave) as chassis:
        handle = chassis.go_to_mark("B1") if mark else chassis.go_to(5.5, 2.5)
        handle.on_done(told.put)
    kind = OutcomeKind.CONNECTION_LOST if leave else OutcomeKind.CANCELLED
    assert told.get(timeout=10.0).kind is kind
    assert handle.outcome.kind is kind


def test_in_asyncio_it_is_called_in_the_loop(sim) -> None:
    async def program() -> tuple[Outcome, bool]:
        done: asyncio.Future[tuple[Outcome, bool]] = asyncio.get_running_loop().create_future()
        here = threading.get_ident()
        async with Chassis(sim.master_uri).aio as robot:
            handle = await robot.forward(0.2).start()
            handle.on_done(lambda outcome: done.set_result((outcome, threading.get_ident() == here)))
            return await asyncio.wait_for(done, 20.0)

    outcome, in_loop = asyncio.run(program())
    assert outcome.arrived
    assert in_loop


def test_turtle_verbs_are_in_metres_and_degrees(sim, chassis) -> None:
    chassis.left(90).wait(20.0)
    assert sim.pose.yaw_degrees == pytest.approx(90, abs=2)
    chassis.forward(0.5).wait(20.0)
    assert sim.pose.y == pytest.approx(0.5, abs=0.05)
    chassis.forward(-0.5).wait(20.0)
    chassis.right(90, speed=0.5).wait(20.0)
    assert sim.pose.yaw_degrees == pytest.approx(0, abs=3)
    assert sim.pose.y == pytest.approx(0.0, abs=0.05)
