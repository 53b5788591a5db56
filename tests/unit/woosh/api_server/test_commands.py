"""`Commands` without a network: the order of stops and commands, and what waited too long."""

from __future__ import annotations

import time
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any, cast

import pytest

from rosproto.errors import RosTimeout
from rosproto.gateway import Access, Refused
from woosh_pure.api_server.commands import ORDER, TASK, TWIST, Commands
from woosh_pure.api_server.state import ApiState
from woosh_pure.robot_api import wire
from woosh_pure.velocity.shaper import DriveLimits

ROBOT = "woosh.robot."
IDLE = {
    "RobotState": {"state": 2},
    "Mode": {"ctrl": 1, "work": 2},
    "TaskProc": {"state": 7, "robotTaskId": 4},
}


class Fake:
    """A robot that is idle, whose topic and services note what comes."""

    def __init__(self) -> None:
        self.published: list[tuple[float, object]] = []
        self.called: list[tuple[int, int]] = []
        self.known = {ROBOT + name: values for name, values in IDLE.items()}
        self.success = self.heard = True
        self.during: Any = lambda: None
        output = SimpleNamespace(
            publish=lambda message, received, client: self.published.append((message.linear.x, client))
        )
        state = SimpleNamespace(
            access=Access(write=["api:*"]),
            known=self.known.get,
            drive_limits=DriveLimits,
            hears=lambda row, seconds: self.heard,
            waiting=nullcontext,
            publications=SimpleNamespace(open=lambda *_: output),
            pool=SimpleNamespace(spawn=lambda work: None),
            velocity_watchdog=SimpleNamespace(gone=lambda client: None),
            node=self,
        )
        self.commands = Commands(cast(ApiState, state), None, share=True)

    def service_client(self, name: str, kind: object) -> Any:
        return nullcontext(SimpleNamespace(call=self.call))

    def call(self, request: Any, timeout: float) -> Any:
        self.called.append((request.task_exect, request.task_id))
        self.during()
        return SimpleNamespace(success=self.success, message="no")

    def do(self, kind: str, body: dict[str, object], received: float | None = None) -> wire.Values:
        at = time.monotonic() if received is None else received
        return self.commands.do("10.0.0.9", kind, wire.load(kind, body), at)


@pytest.fixture
def robot() -> Fake:
    return Fake()


def test_a_velocity_that_waited_is_not_obeyed_and_a_zero_is(robot: Fake) -> None:
    old = time.monotonic() - 2.0
    with pytest.raises(Refused, match="waited for too long"):
        robot.do(TWIST, {"linear": 0.2}, old)
    robot.do(TWIST, {}, old)
    robot.do(TWIST, {"linear": 0.2})
    assert robot.published == [(0.0, "10.0.0.9"), (pytest.approx(0.2), "10.0.0.9")]


def test_a_robot_that_is_not_heard_is_not_driven(robot: Fake) -> None:
    robot.heard = False
    with pytest.raises(Refused, match="not heard"):
        robot.do(TWIST, {"linear": 0.2})
    robot.do(TWIST, {})


def test_a_robot_that_tells_its_state_on_change_only_is_driven_as_by_chassis_velocity(robot: Fake) -> None:
    """What is not known speaks against nothing; what is known does."""
    for name in IDLE:
        del robot.known[ROBOT + name]
    robot.do(TWIST, {"linear": 0.2})
    for name, values in (("Mode", {"ctrl": 2}), ("RobotState", {"state": 4}), ("TaskProc", {"state": 3})):
        robot.known[ROBOT + name] = values
        with pytest.raises(Refused, match="so it is not driven"):
            robot.do(TWIST, {"linear": 0.2})
        del robot.known[ROBOT + name]


def test_the_velocities_of_one_that_drives_do_not_wait(robot: Fake) -> None:
    assert robot.commands.waits(TWIST, "10.0.0.9")
    robot.do(TWIST, {"linear": 0.2})
    assert not robot.commands.waits(TWIST, "10.0.0.9")
    assert robot.commands.waits(TWIST, "10.0.0.8")
    assert robot.commands.waits(TASK, "10.0.0.9")
    robot.commands.gone("10.0.0.9")
    assert robot.commands.waits(TWIST, "10.0.0.9")


def test_a_cancel_that_comes_while_a_task_is_sent_ends_it(robot: Fake) -> None:
    """The robot has not told the task yet: its number is known here."""
    received = time.monotonic()

    def cancel() -> None:
        robot.during = lambda: None
        robot.do(ORDER, {"order": 4}, received + 0.1)

    robot.during = cancel
    with pytest.raises(Refused, match="cancelled by another request"):
        robot.do(TASK, {"taskId": 9, "markNo": "A1"}, received)
    assert robot.called == [(1, 9), (4, 9), (4, 9)]
    with pytest.raises(Refused, match="cancelled by another request"):
        robot.do(TASK, {"taskId": 10, "markNo": "A1"}, received)  # it was asked for before the cancel
    assert robot.called[-1] == (4, 9)
    robot.do(TASK, {"taskId": 11, "markNo": "A1"}, received + 0.2)
    assert robot.called[-1] == (1, 11)


def test_a_cancelled_task_whose_reply_is_late_is_cancelled_again(robot: Fake) -> None:
    """The robot may have accepted it after it refused the cancel."""
    received = time.monotonic()

    def cancel_and_stay_silent() -> None:
        robot.during = lambda: None
        robot.do(ORDER, {"order": 4}, received + 0.1)
        raise RosTimeout("no reply", what="/exec_task", seconds=5.0)

    robot.during = cancel_and_stay_silent
    with pytest.raises(RosTimeout):
        robot.do(TASK, {"taskId": 9, "markNo": "A1"}, received)
    assert robot.called == [(1, 9), (4, 9), (4, 9)]


def test_a_cancel_means_the_task_that_is_told_and_the_last_one_from_here(robot: Fake) -> None:
    robot.do(TASK, {"taskId": 9, "markNo": "A1"})
    robot.known[ROBOT + "TaskProc"] = {"state": 3, "robotTaskId": 4}
    robot.success = False
    with pytest.raises(Refused, match="no"):
        robot.do(ORDER, {"order": 4})
    assert robot.called[1:] == [(4, 4), (4, 9)]
    with pytest.raises(Refused):
        robot.do(ORDER, {"order": 2})
    assert robot.called[3:] == [(2, 4)]
