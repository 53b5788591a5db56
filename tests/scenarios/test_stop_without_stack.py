"""A stop in the deepest frames before a RecursionError: the robot stands, however few calls are left."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.support.load import crowd
from woosh_pure import Chassis
from woosh_pure.stopping import StopReport

LIMIT = 450
FREE = (0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 22, 30)
"""Frames that are left to what the deepest frame calls, that of `stop` itself not counted."""


@pytest.fixture(autouse=True)
def in_real_time(real_time):
    """What is seen while it moves."""


@pytest.fixture
def shallow() -> Iterator[None]:
    """A lower recursion limit."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(LIMIT + depth_now())
    yield
    sys.setrecursionlimit(before)


def depth_now() -> int:
    frame, depth = sys._getframe(1), 0
    while frame is not None:
        frame, depth = frame.f_back, depth + 1  # type: ignore[assignment]
    return depth


def _down(frames: int, do: Callable[[], Any]) -> Any:
    return _down(frames - 1, do) if frames else do()


class _Method:
    """What `do` calls needs one frame and nothing else, as `stop` at least does."""

    def call(self, **options: object) -> bool:
        return True


def at_the_end(free: int, do: Callable[[], Any]) -> Any:
    """Call `do` with so many frames left to the method that it calls."""
    method = _Method()
    room = LIMIT
    while True:
        try:
            _down(room, lambda: method.call(timeout=1.0))
            break
        except RecursionError:
            room -= 1
    return _down(room - free, do)


def tried(free: int, do: Callable[[], Any]) -> Any:
    """The result, or the exception."""
    try:
        return at_the_end(free, do)
    except Exception as error:
        return error


def begin(chassis: Chassis, what: str) -> Any:
    if what == "velocity":
        drive = chassis.velocity(bypasses_protection=True).__enter__()
        drive.set(0.05, valid_for=5.0)
        return drive
    return chassis.go_to(2.5, 0.0) if what == "goal" else chassis.go_to_mark("B1")


def is_over(sim) -> bool:
    return bool(
        sim.world.motion is None
        and not sim.world.tasks.busy
        and sim.world.body.velocity.is_standing(0.0, 0.0)
    )


@pytest.mark.slow
@pytest.mark.promise("the stack of the caller is used up")
@pytest.mark.parametrize("what", ["velocity", "goal", "task"])
def test_stop_returns_a_report_and_the_robot_stands(sim, chassis, until, shallow, what):
    for free in FREE:
        begin(chassis, what)
        until(lambda: not sim.world.body.velocity.is_standing())
        report = tried(free, lambda: chassis.stop(timeout=1.0))
        until(lambda: is_over(sim), 4.0 * crowd(), f"standing with {free} frames")
        assert isinstance(report, StopReport), (free, report)
        if "recursion" in str(report):  # what is not known yet is not said; it is filled in
            assert free < 25
            until(lambda: report.standing is not None)  # noqa: B023
            assert "recursion" not in str(report)
        until(lambda: not chassis.under_way)


@pytest.mark.slow
@pytest.mark.promise("the stack of the caller is used up")
@pytest.mark.parametrize(
    ("what", "name", "arguments"),
    [
        ("velocity", "__exit__", (None, None, None)),
        ("goal", "cancel", (1.0,)),
        ("task", "cancel", (1.0,)),
        ("task", "wait", (20.0,)),
    ],
)
def test_so_do_a_cancel_a_wait_and_the_end_of_a_block(sim, chassis, until, shallow, what, name, arguments):
    """A wait that cannot wait ends its goal, as with any other exception."""
    for free in FREE[:8]:
        begun = begin(chassis, what)
        until(lambda: not sim.world.body.velocity.is_standing())
        method = getattr(begun, name)
        tried(free, lambda: method(*arguments))  # noqa: B023
        until(lambda: is_over(sim), 4.0 * crowd(), f"standing with {free} frames")
        until(lambda: not chassis.under_way)


@pytest.mark.slow
@pytest.mark.promise("the stack of the caller is used up")
@pytest.mark.parametrize("what", ["velocity", "task"])
def test_so_does_close(sim, until, shallow, what):
    for free in FREE[:8]:
        chassis = Chassis(sim.master_uri)
        begin(chassis, what)
        until(lambda: not sim.world.body.velocity.is_standing())
        tried(free, chassis.close)
        until(lambda: is_over(sim), 6.0 * crowd(), f"standing with {free} frames")
        chassis.close()


@pytest.mark.slow
def test_so_does_an_awaited_stop(sim, until, shallow):
    """The coroutine needs a frame more than the method."""

    async def trial(chassis: Chassis, free: int) -> None:
        coroutine = chassis.aio.stop(timeout=1.0)
        tried(free, lambda: coroutine.send(None))
        await asyncio.sleep(0)
        coroutine.close()

    for free in FREE[2:8]:
        with Chassis(sim.master_uri) as chassis:
            begin(chassis, "task")
            until(lambda: not sim.world.body.velocity.is_standing())
            asyncio.run(trial(chassis, free))
            until(lambda: is_over(sim), 6.0 * crowd(), f"standing with {free} frames")


@pytest.mark.slow
def test_a_stop_without_stack_is_not_carried_out_later(sim, chassis, until, shallow):
    """Nothing was under way: a motion that is begun after it goes on."""
    begin(chassis, "velocity").__exit__(None, None, None)
    tried(0, lambda: chassis.stop(timeout=0.5))
    until(lambda: chassis.stop(timeout=1.0).standing)
    handle = chassis.move(0.2)
    assert handle.wait(30.0).arrived
