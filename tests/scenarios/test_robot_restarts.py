"""The robot is started again under a Chassis that stays: what was heard before is not known any more, and refuses nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from rosproto import Master
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import RobotMode
from woosh_pure.readiness import Ready


class Yard:
    """A master that goes on, and a robot that can be switched off and on."""

    def __init__(self, stack: ExitStack) -> None:
        self.master = stack.enter_context(Master(host="127.0.0.1", port=0))
        self.sim: SimulatedChassis | None = None
        stack.callback(self.off)

    def on(self, **options: Any) -> SimulatedChassis:
        silent = {"latch_status": False, "repeat_status_code": False}
        options = {"speed": 8.0, "full_graph": False, **silent, **options}
        self.sim = SimulatedChassis(master_uri=self.master.uri, **options)
        self.sim.__enter__()
        return self.sim

    def off(self) -> None:
        if self.sim is not None:
            self.sim.__exit__(None, None, None)
            self.sim = None


@pytest.fixture
def yard() -> Iterator[Yard]:
    with ExitStack() as stack:
        yield Yard(stack)


@pytest.fixture
def chassis(yard: Yard) -> Iterator[Chassis]:
    yard.on()
    with Chassis(yard.master.uri) as connected:
        connected.readiness()
        yield connected


def restart(yard: Yard, chassis: Chassis, until: Callable[..., None], **options: Any) -> SimulatedChassis:
    """Off and on again, until its new links are there."""
    before = {name: chassis.feed(name).sources for name in ("status", "status_code")}
    yard.off()
    sim = yard.on(**options)
    until(lambda: all(chassis.feed(name).sources - before[name] for name in before), 30.0, "the new links")
    return sim


def test_an_emergency_stop_of_before_refuses_nothing(
    yard: Yard, chassis: Chassis, until: Callable[..., None]
) -> None:
    assert yard.sim is not None
    yard.sim.press_emergency_stop()
    until(lambda: chassis.faults and chassis.readiness().answer is Ready.NO)
    restart(yard, chassis, until)
    readiness = chassis.readiness()
    assert not readiness.blocked, readiness
    assert any("may be over" in reason.text for reason in readiness.reasons), "it is told, and not believed"
    assert readiness.answer is Ready.UNKNOWN
    assert chassis.faults == ()
    assert chassis.go_to_mark("A1").wait(timeout=60.0).arrived
    assert chassis.readiness().answer is Ready.YES


def test_the_word_of_the_new_robot_ends_what_was_before(
    yard: Yard, chassis: Chassis, until: Callable[..., None]
) -> None:
    """Its status is latched here, as on a chassis that tells it to newcomers."""
    assert yard.sim is not None
    yard.sim.press_emergency_stop()
    until(lambda: chassis.faults)
    restart(yard, chassis, until, latch_status=True)
    until(lambda: chassis.readiness().answer is Ready.YES)
    assert chassis.faults.known
    assert chassis.readiness().reasons == ()


def test_a_mode_of_before_refuses_nothing(yard: Yard, chassis: Chassis, until: Callable[..., None]) -> None:
    assert yard.sim is not None
    yard.sim.set_mode(RobotMode.MANUAL)
    until(lambda: chassis.readiness().blocked)
    restart(yard, chassis, until)
    assert not chassis.readiness().blocked
    assert chassis.readiness().answer is Ready.UNKNOWN


def test_an_emergency_stop_that_is_still_pressed_refuses_again(
    yard: Yard, chassis: Chassis, until: Callable[..., None]
) -> None:
    assert yard.sim is not None
    yard.sim.press_emergency_stop()
    until(lambda: chassis.faults)
    restart(yard, chassis, until).press_emergency_stop()
    until(lambda: chassis.readiness().blocked and chassis.faults)  # two topics


def test_that_it_moved_before_the_restart_is_no_yes_after_it(
    yard: Yard, chassis: Chassis, until: Callable[..., None]
) -> None:
    assert chassis.move(0.1).wait(timeout=30.0).arrived
    assert chassis.readiness().answer is Ready.YES
    restart(yard, chassis, until)
    assert chassis.readiness().answer is Ready.UNKNOWN
