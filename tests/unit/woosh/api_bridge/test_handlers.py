"""`ApiHandlers` without a network: tasks whose request was not answered, and what a goal waits for."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from rosproto.action import GoalStatus
from rosproto.codec import Message
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.numeric import encode_png
from tests.support.waiting import until
from woosh_pure.api_bridge import handlers as module
from woosh_pure.api_bridge.client import ApiLink
from woosh_pure.api_bridge.handlers import MAX_FEEDBACKS, ORDER, ApiHandlers
from woosh_pure.api_bridge.publishing import TASK, Publishing
from woosh_pure.robot_api.commands import ACTION, STATES
from woosh_pure.values.messages import message_type, service_type

STEP = ACTION + "StepControl"


class Robot:
    """What it is asked and sent; it answers as `during` does."""

    def __init__(self) -> None:
        self.up = True
        self.posted: list[str] = []
        self.during: Any = dict
        self.known = Publishing(lambda row: None)
        self.by_http: dict[str, Any] = {}
        requests: Any = SimpleNamespace(ask=lambda request, **_: self.by_http[request])
        self.closed = threading.Event()
        self.handlers = ApiHandlers(cast(ApiLink, self), requests, self.known, self.closed)

    def ask(self, request: str, body: object, timeout: float) -> Any:
        return self.during()

    def post(self, request: str, body: object, done: Any = None) -> None:
        if self.up:
            self.posted.append(request)
        else:
            done(ConnectionLost("gone", peer="robot"))

    def task(self, task_id: int, state: int = 3) -> None:
        """The robot tells its task."""
        self.known.values[TASK] = {"robotTaskId": task_id, "state": state}
        self.handlers.task_seen()

    def execute(self, task_id: int, command: int = 1) -> Any:
        request = service_type("woosh_msgs/ExecTask").Request(
            task_exect=command, task_id=task_id, mark_no="A1"
        )
        return self.handlers.services["/exec_task"](request)


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Robot:
    monkeypatch.setattr(module, "UNKNOWN_SECONDS", 0.0)
    return Robot()


def lose(robot: Robot, task_id: int, *, seen: bool) -> None:
    def silent() -> None:
        if seen:
            robot.task(task_id)
        raise RosTimeout("no answer", what="ExecTask", seconds=8.0)

    robot.during = silent
    with pytest.raises(RosError):
        robot.execute(task_id)


def test_a_task_that_was_seen_before_its_answer_was_late_is_cancelled(robot: Robot) -> None:
    """The robot tells it once: nothing more may come."""
    lose(robot, 9, seen=True)
    assert robot.posted == [ORDER]


def test_a_task_that_is_seen_after_its_answer_was_late_is_cancelled_once(robot: Robot) -> None:
    lose(robot, 9, seen=False)
    robot.task(8)
    assert robot.posted == []
    robot.task(9)
    robot.task(9)
    assert robot.posted == [ORDER]


def test_a_task_that_is_sent_again_with_its_number_is_not_cancelled(robot: Robot) -> None:
    """Programs number their tasks as they like."""
    lose(robot, 9, seen=False)
    robot.during = dict
    assert robot.execute(9)["success"]
    robot.task(9)
    assert robot.posted == []


def test_a_cancel_that_is_lost_is_sent_for_the_same_task_when_the_robot_is_there_again(robot: Robot) -> None:
    def lost() -> None:
        robot.up = False
        raise ConnectionLost("gone", peer="robot")

    robot.task(9)
    robot.during = lost
    with pytest.raises(ConnectionLost):
        robot.execute(9, command=4)
    assert robot.posted == []
    robot.up = True
    robot.task(8)
    assert robot.posted == []
    robot.task(9)
    robot.task(9)
    assert robot.posted == [ORDER]


def test_a_task_without_an_answer_is_given_up_when_the_bridge_closes(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "UNKNOWN_SECONDS", 60.0)
    worker = threading.Thread(target=lose, args=(robot, 9), kwargs={"seen": True}, daemon=True)
    worker.start()
    until(lambda: robot.posted)
    robot.closed.set()
    worker.join(5.0)
    assert not worker.is_alive()


def test_a_map_is_fetched_beside_the_link(robot: Robot) -> None:
    """Its answer may be megabytes: velocities and measured velocities would wait behind it."""
    picture = encode_png(np.full((2, 3), 254, np.uint8))
    maps = [{"name": "upper"}, {"name": "ground", "resolution": 0.05, "mapPng": picture}]
    robot.by_http = {"woosh.robot.Scene": {"mapName": "ground"}, "woosh.map.SceneData": {"maps": maps}}
    robot.during = lambda: pytest.fail("asked by the link")
    found = robot.handlers.services["/aic_map_server/get_map"](cast(Any, None))["map"]
    assert isinstance(found, Message)
    assert (found.info.width, found.info.height) == (3, 2)


def test_a_goal_that_a_closed_bridge_has_ended_is_followed_no_longer(robot: Robot) -> None:
    goal = SimpleNamespace(
        goal=message_type("woosh_msgs/StepControlGoal")(), cancel_requested=False, status=GoalStatus.ACTIVE
    )
    robot.up = False
    worker = threading.Thread(target=robot.handlers.actions["/cmd_vel_control"], args=(goal,), daemon=True)
    worker.start()
    goal.status = GoalStatus.ABORTED
    worker.join(5.0)
    assert not worker.is_alive()


def test_a_flood_of_feedbacks_waits_in_bounded_memory_and_hides_no_end(robot: Robot) -> None:
    told: list[object] = []
    slow, go_on = threading.Event(), threading.Event()

    def publish(report: object) -> None:
        slow.set()
        go_on.wait(10.0)
        told.append(report)

    goal = SimpleNamespace(
        goal=message_type("woosh_msgs/StepControlGoal")(),
        cancel_requested=False,
        status=GoalStatus.ACTIVE,
        publish_feedback=publish,
        succeed=told.append,
    )
    worker = threading.Thread(target=robot.handlers.actions["/cmd_vel_control"], args=(goal,), daemon=True)
    runs, done = (
        {"action": STEP, "code": 0, "state": STATES[each]} for each in ("kRosExecuting", "kRosSuccess")
    )
    worker.start()

    def begun() -> bool:
        robot.handlers.feedbacks({"fbs": [runs]})
        return slow.is_set()

    until(begun)
    robot.handlers.feedbacks({"fbs": [runs] * (2 * MAX_FEEDBACKS)})
    robot.handlers.feedbacks({"fbs": [done]})
    go_on.set()
    worker.join(5.0)
    assert len(told) == 1 + MAX_FEEDBACKS + 1
