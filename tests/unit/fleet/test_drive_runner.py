"""Drives as goals of a chassis: the end of each is reported once, and whether it is known."""

from __future__ import annotations

import queue
import threading
from typing import Any

import pytest

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.enums import NavDirection
from woosh_pure.errors import MotionRefused
from woosh_pure.fleet.drive_runner import DriveRunner
from woosh_pure.fleet.messages.elements import Edge, Node, NodePosition
from woosh_pure.fleet.order.events import Drive, DriveEnded
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind

NODE = Node("b", 2, True, NodePosition(2.0, 0.0, "hall", 0.0))


class Goal:
    """A goal that ends on demand."""

    def __init__(self) -> None:
        self.outcome: queue.SimpleQueue[Outcome] = queue.SimpleQueue()
        self.cancelled = threading.Event()
        self.cancel_fails: RosError | None = None

    def wait(self, timeout: float | None, *, raises: bool) -> Outcome:
        return self.outcome.get(timeout=10.0)

    def cancel(self) -> None:
        self.cancelled.set()
        if self.cancel_fails is not None:
            raise self.cancel_fails


class Robot:
    """What the driver uses of a chassis.

    Attributes:
        modes: (speed, direction) pairs that were set.
        fails: Raised instead of taking a goal.
        mode_fails: Raised instead of taking speed and direction.
    """

    def __init__(self) -> None:
        self.modes: list[tuple[float, NavDirection]] = []
        self.goals: queue.SimpleQueue[Goal] = queue.SimpleQueue()
        self.fails: Exception | None = None
        self.mode_fails: RosError | None = None

    def set_navigation_mode(
        self, mode: Any, *, max_speed: float, direction: NavDirection, timeout: float
    ) -> None:
        self.modes.append((max_speed, direction))
        if self.mode_fails is not None:
            raise self.mode_fails

    def request(self) -> CallScope:
        return CallScope()

    def go_to(self, x: float, y: float, yaw: float, **options: Any) -> Goal:
        if self.fails is not None:
            raise self.fails
        goal = Goal()
        self.goals.put(goal)
        return goal


class Hands:
    """A driver on such a robot, and what it reports."""

    def __init__(self) -> None:
        self.robot = Robot()
        self.ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.driver = DriveRunner(self.robot, self.ended.put, lambda: None)  # type: ignore[arg-type]
        self.token = 0

    def drive(self, **options: Any) -> Goal:
        self.send(**options)
        return self.robot.goals.get(timeout=10.0)

    def send(self, **options: Any) -> None:
        self.token += 1
        self.driver.drive(Drive(self.token, NODE, Edge("ab", 1, True, "a", "b", options)))

    def end(self) -> tuple[int, bool, bool]:
        """Token, whether it arrived, whether that is known."""
        end = self.ended.get(timeout=10.0)
        assert isinstance(end, DriveEnded)
        return end.token, end.arrived, end.known


@pytest.fixture
def hands() -> Hands:
    return Hands()


@pytest.mark.parametrize(
    ("kind", "text", "arrived", "known"),
    [
        (OutcomeKind.ARRIVED, "", True, True),
        (OutcomeKind.FAILED, "", False, True),
        (OutcomeKind.REJECTED, "", False, True),
        (OutcomeKind.REPLACED, "", False, True),
        (OutcomeKind.CANCELLED, "", False, True),
        (OutcomeKind.CANCELLED, NOT_CONFIRMED, False, False),
        (OutcomeKind.TIMED_OUT, "", False, False),
        (OutcomeKind.CONNECTION_LOST, "", False, False),
    ],
)
def test_each_outcome_is_reported_for_what_is_known(
    hands: Hands, kind: OutcomeKind, text: str, arrived: bool, known: bool
) -> None:
    """A goal that the chassis may go on with has not ended."""
    goal = hands.drive()
    goal.outcome.put(Outcome(kind, "x", text))
    assert hands.end() == (1, arrived, known)


@pytest.mark.parametrize(
    ("kind", "by_us", "by_others"),
    [
        (OutcomeKind.CANCELLED, "", True),
        (OutcomeKind.REPLACED, "", True),
        (OutcomeKind.CANCELLED, "stop() was called", False),
        (OutcomeKind.FAILED, "", False),
    ],
)
def test_a_drive_that_others_ended_is_reported_as_such(
    hands: Hands, kind: OutcomeKind, by_us: str, by_others: bool
) -> None:
    """Only so is a stop by another program known."""
    hands.drive().outcome.put(Outcome(kind, "x", "preempted", by_us=by_us))
    assert hands.ended.get(timeout=10.0).by_others is by_others


@pytest.mark.parametrize(
    ("error", "known"),
    [
        (MotionRefused("not ready"), True),
        (ValueError("too far"), True),
        (RosTimeout("no server"), False),
        (ConnectionLost("gone"), False),
        (KeyError("ours"), False),
    ],
)
def test_what_was_refused_was_not_sent_and_anything_else_may_have_been(
    hands: Hands, error: Exception, known: bool
) -> None:
    """One report for each."""
    hands.robot.fails = error
    hands.send()
    assert hands.end() == (1, False, known)


def test_a_cancel_that_cannot_be_sent_is_reported_once(hands: Hands) -> None:
    """The drive may go on; its later end is not reported again."""
    goal = hands.drive()
    goal.cancel_fails = ConnectionLost("gone")
    hands.driver.halt(1)
    assert hands.end() == (1, False, False)
    goal.outcome.put(Outcome(OutcomeKind.ARRIVED, "x"))
    hands.drive().outcome.put(Outcome(OutcomeKind.ARRIVED, "y"))
    assert hands.end() == (2, True, True)


def test_a_drive_that_was_to_be_replaced_is_ended_where_its_successor_fails(hands: Hands) -> None:
    """Else it would drive on unnoticed."""
    first = hands.drive()
    hands.robot.fails = MotionRefused("not ready")
    hands.send()
    assert first.cancelled.wait(10.0)
    assert hands.end() == (2, False, True)


def test_speed_and_direction_are_told_before_each_drive(hands: Hands) -> None:
    """The chassis forgets them with a restart, and other programs set them."""
    for options in ({"maxSpeed": 0.25}, {"maxSpeed": 0.25}, {}, {"orientation": 3.14159}, {}):
        hands.drive(**options)
    decides = NavDirection.CHASSIS_DECIDES
    assert hands.robot.modes == [
        (0.25, decides), (0.25, decides), (0.0, decides), (0.0, NavDirection.BACKWARD), (0.0, decides),
    ]  # fmt: skip


def test_an_edge_whose_speed_cannot_be_set_is_not_driven(hands: Hands) -> None:
    """Nor the next one without a limit, because the old one holds; without any limit it drives as configured."""
    hands.robot.mode_fails = RosTimeout("nobody offers /navigation_mode")
    hands.drive()
    hands.drive()
    assert len(hands.robot.modes) == 1, "a chassis without it is asked once"
    hands.send(maxSpeed=0.25)
    assert hands.end()[1:] == (False, True)
    hands.robot.mode_fails = None
    hands.drive(maxSpeed=0.25)
    hands.robot.mode_fails = RosTimeout("gone")
    hands.send()
    assert hands.end()[1:] == (False, True)
