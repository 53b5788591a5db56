"""Times, rates and distances may be numpy's: a wait ends when it should, and what it ends is cancelled.

`time.monotonic() + np.float16(0.5)` is infinite or wrong by half a minute, and a lock takes no np.float32.
"""

from __future__ import annotations

import asyncio
import time
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import rosproto
from rosproto import aio
from rosproto.errors import RosTimeout
from rosproto.tf import TransformBuffer
from rosproto.time import Duration
from tests.support.load import crowd
from tests.support.victim import eventually
from woosh_pure import GoalFailed, OutcomeKind, Pose2D
from woosh_pure.motion.steps import Step

KINDS = [
    np.float16,
    np.float32,
    np.float64,
    lambda value: np.array(value),
    Fraction,
    lambda v: Decimal(str(v)),
]
NAMES = ["float16", "float32", "float64", "array", "Fraction", "Decimal"]
every_kind = pytest.mark.parametrize("kind", KINDS, ids=NAMES)
String = "std_msgs/String"


@pytest.fixture(scope="module")
def graph():
    with rosproto.Master() as master, rosproto.Node("/n", master_uri=master.uri) as node:
        yield node


@every_kind
def test_waits_of_rosproto_end_in_time(graph, kind):
    soon = kind(0.0625)
    began = time.monotonic()
    with graph.subscriber("/silent", String) as silent:
        for wait in (silent.next, silent.wait_for_connection):
            with pytest.raises(RosTimeout):
                wait(timeout=soon)
    with pytest.raises(RosTimeout):
        graph.publisher("/unheard", String).wait_for_connection(timeout=soon)
    with pytest.raises(RosTimeout):
        graph.wait_for_message("/silent", String, timeout=soon)
    with pytest.raises(RosTimeout):
        graph.wait_for_service("/nobody", timeout=soon)
    with pytest.raises(RosTimeout):
        rosproto.ActionClient(graph, "/none", "actionlib/TestAction", status_timeout=kind(3)).wait_for_server(
            timeout=soon
        )
    with pytest.raises(RosTimeout):
        TransformBuffer().wait("a", "b", timeout=soon)
    assert graph.wait(timeout=soon) is False
    assert time.monotonic() - began < 4.0 * crowd()


@every_kind
def test_clocks_of_rosproto_take_them(graph, kind):
    began = time.monotonic()
    assert graph.clock.sleep(kind(0.0625))
    rate = graph.clock.rate(kind(16))
    assert rate.sleep()
    calls = []
    graph.clock.timer(kind(0.0625), calls.append, oneshot=True)._thread.join(4.0)
    assert len(calls) == 1
    assert Duration.from_sec(kind(0.5)) == Duration(kind(0.5)) == Duration(0, 500_000_000)
    assert 0.1 < time.monotonic() - began < 4.0 * crowd()


@every_kind
def test_so_do_those_of_asyncio(graph, kind):
    async def main() -> None:
        async with aio.Node("/a", master_uri=graph.master_uri) as node:
            silent = await node.subscriber("/silent", String)
            with pytest.raises((RosTimeout, TimeoutError, asyncio.TimeoutError)):
                await silent.next(timeout=kind(0.0625))

    asyncio.run(main())


@pytest.mark.promise("`handle.wait(timeout=...)` runs out")
@every_kind
def test_a_wait_for_a_goal_ends_in_time_and_cancels(sim, real_time, chassis, until, kind):
    handle = chassis.go_to(kind(2.5), kind(0), kind(0.5))
    with pytest.raises(GoalFailed) as caught:
        handle.wait(timeout=kind(0.25))
    assert caught.value.outcome.kind is OutcomeKind.TIMED_OUT
    until(lambda: sim.world.motion is None)
    handle = chassis.move(kind(2.5), speed=kind(0.5), timeout=kind(0.25))
    assert handle.wait(raises=False).kind is OutcomeKind.TIMED_OUT
    assert chassis.go_to(2.5, 0.0).cancel(timeout=kind(3)).kind is OutcomeKind.CANCELLED
    assert chassis.stop(timeout=kind(2)).standing


@every_kind
def test_a_velocity_lapses_in_time(sim, chassis, until, kind):
    options = {"max_linear": kind(0.25), "max_angular": kind(0.5), "feedback_timeout": kind(2)}
    with chassis.velocity(bypasses_protection=True, **options) as drive:

        def drives() -> bool:
            drive.set(
                kind(0.0625), kind(0), valid_for=kind(0.25)
            )  # on a busy computer it lapses before it is sent
            return not drive.sending.is_standing(0.0, 0.0)

        until(drives)
        until(lambda: drive.sending.is_standing(0.0, 0.0), 1.5 * crowd())
        began = time.monotonic()
        drive.hold(kind(0.0625), seconds=kind(0.25))
        assert 0.2 < time.monotonic() - began < 2.0 * crowd()


@every_kind
def test_feeds_and_states_are_waited_for_in_time(sim, chassis, kind):
    began = time.monotonic()
    with pytest.raises(RosTimeout):
        chassis.feed("/lift").wait(kind(0.0625))
    with pytest.raises(RosTimeout):
        chassis.odometer.wait_for(lambda _: False, kind(0.0625))
    with pytest.raises(RosTimeout):
        chassis.wait_until(lambda _: False, kind(0.0625))
    assert time.monotonic() - began < 4.0 * crowd()
    chassis.readiness()
    eventually(lambda: chassis.feed("status").sources, 20.0)  # the state is told once, to who is there
    sim.press_emergency_stop()
    eventually(lambda: chassis.readiness().blocked, 20.0)
    began = time.monotonic()
    with pytest.raises(RosTimeout):
        chassis.wait_until_ready(kind(0.0625))
    assert time.monotonic() - began < 4.0 * crowd()


def test_values_hold_floats():
    pose, step = (
        Pose2D(np.float16(1), np.float32(2), np.int8(1)),
        Step.straight(np.float16(9.9), np.float32(0.5)),
    )
    assert [type(value) for value in (pose.x, pose.y, pose.yaw, step.data, step.speed)] == [float] * 5


@pytest.mark.promise("Ctrl-C in `handle.wait()`")
@pytest.mark.parametrize("error", [RuntimeError, TypeError, SystemExit, GeneratorExit], ids=str)
def test_whatever_ends_a_wait_cancels_its_goal(sim, real_time, chassis, until, error):
    def fail() -> None:
        raise error("in the middle")

    handle = chassis.go_to(2.5, 0.0)
    with pytest.raises(error):
        handle.wait(meanwhile=fail)
    assert handle.outcome.kind is OutcomeKind.CANCELLED
    assert handle.outcome.by_us == "its wait was interrupted"
    until(lambda: sim.world.motion is None)


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int64, lambda value: np.array(value)])
def test_whole_numbers_of_a_task_may_be_numpys(sim, chassis, kind):
    """What a project counts comes out of tables and arrays."""
    task = chassis.task(1, "A1", type_number=kind(5), custom=kind(3))
    assert task.wait(timeout=20.0).arrived
    for wrong in ({"type_number": np.float32(5)}, {"custom": 2.0}, {"custom": np.int16(300)}):
        with pytest.raises(ValueError, match="expected a whole number"):
            chassis.task(1, "A1", **wrong)
