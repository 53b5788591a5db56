"""`ApiLink` against a robot by script: zeros, velocities, late answers, lost connections."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.errors import CodecError, ConnectionLost, RosTimeout
from tests.support.extras import needs
from tests.support.waiting import until
from woosh_pure.errors import ApiRefused
from woosh_pure.robot_api.http import ApiAddress

needs("api")

from tests.support.scripted_robot import ScriptedRobot  # noqa: E402
from woosh_pure.api_bridge import client  # noqa: E402
from woosh_pure.api_bridge.client import LATE_SECONDS, ApiLink  # noqa: E402

POSE = "woosh.robot.PoseSpeed"
AHEAD = {"linear": 0.25, "angular": 0.0}


@pytest.fixture
def robot() -> Iterator[ScriptedRobot]:
    with ScriptedRobot() as robot:
        yield robot


class Link(ApiLink):
    """With what it was told."""

    def __init__(self, port: int, host: str = "127.0.0.1") -> None:
        self.pushes: list[tuple[str, Any]] = []
        self.words: list[str] = []
        topics = [POSE]
        super().__init__(
            ApiAddress(host, port), topics, lambda *push: self.pushes.append(push), self.words.append
        )


@pytest.fixture
def link(robot: ScriptedRobot) -> Iterator[Link]:
    link = Link(robot.port)
    link.start()
    yield link
    link.close()


def threads_of_links() -> list[str]:
    return [each.name for each in threading.enumerate() if each.name.startswith("woosh:robot api ")]


def drive(link: Link, body: dict[str, float] = AHEAD, times: int = 1) -> None:
    for _ in range(times):
        link.velocity(body)
        time.sleep(0.02)


def test_it_asks_and_is_answered_by_number(robot: ScriptedRobot, link: Link) -> None:
    assert link.ask(POSE)["pose"] == {"x": 1.0, "y": 2.0, "theta": 0.5}
    robot.answers["Battery"] = lambda _: "not now"
    with pytest.raises(ApiRefused, match="not now"):
        link.ask("woosh.robot.Battery")


def test_an_answer_that_does_not_come_is_a_timeout(robot: ScriptedRobot, link: Link) -> None:
    robot.answers["Battery"] = lambda _: None
    with pytest.raises(RosTimeout):
        link.ask("woosh.robot.Battery", timeout=0.1)


def test_nobody_there_is_told_with_the_address_and_the_port() -> None:
    with pytest.raises(ConnectionLost, match=r"127\.0\.0\.1:9[^0-9].*5480"):
        Link(9).start()


def test_a_push_of_a_subscribed_type_is_received(robot: ScriptedRobot, link: Link) -> None:
    until(lambda: POSE in robot.topics)
    robot.push("PoseSpeed", {"mileage": 43})
    robot.push("Battery", {"power": 1})
    until(lambda: link.pushes)
    assert [(name, values["mileage"]) for name, values in link.pushes] == [(POSE, 43)]


@pytest.mark.promise("a velocity for a robot that has only the Robot API")
def test_a_velocity_is_sent_once_and_never_repeated(robot: ScriptedRobot, link: Link) -> None:
    link.velocity(AHEAD)
    until(lambda: robot.of("Twist"))
    time.sleep(0.3)
    assert robot.of("Twist") == [{"linear": 0.25}]


def test_a_zero_is_sent_three_times(robot: ScriptedRobot, link: Link) -> None:
    link.zero()
    until(lambda: not link.zero_due)
    zeros = [at for at, word, body in robot.asked if word == "Twist" and body == {}]
    assert len(zeros) == 3
    assert 0.08 < zeros[-1] - zeros[0] < 0.5


def test_a_zero_is_sent_until_one_is_accepted(robot: ScriptedRobot, link: Link) -> None:
    robot.answers["Twist"] = lambda _: "busy"
    link.zero()
    until(lambda: len(robot.of("Twist")) >= 4)
    assert link.zero_due
    robot.answers["Twist"] = lambda _: {}
    until(lambda: not link.zero_due)


def test_a_zero_passes_what_waits(robot: ScriptedRobot, link: Link) -> None:
    """Four velocities have no answer, so the next ones wait, each in place of the one before; a zero replaces the last."""
    robot.answers["Twist"] = lambda body: {} if not body else None
    drive(link, times=30)
    link.zero()
    until(lambda: not link.zero_due)
    assert robot.of("Twist") == [{"linear": 0.25}] * 4 + [{}] * 3


def test_a_velocity_that_waited_is_not_sent_late(robot: ScriptedRobot, link: Link) -> None:
    hold = threading.Event()
    robot.answers["Twist"] = lambda body: {} if hold.wait(5.0) else None
    drive(link, times=30)
    time.sleep(0.4)
    hold.set()
    until(lambda: link.silence == 0.0)
    assert robot.of("Twist") == [{"linear": 0.25}] * 4


def test_a_refused_velocity_tells_the_robots_words(robot: ScriptedRobot, link: Link) -> None:
    robot.answers["Twist"] = lambda body: "a task is under way" if body else {}
    link.velocity(AHEAD)
    until(lambda: link.words == ["a task is under way"])


def test_after_a_refused_velocity_none_is_sent_before_a_zero(robot: ScriptedRobot, link: Link) -> None:
    robot.answers["Twist"] = lambda body: "manual" if body else {}
    link.velocity(AHEAD)
    until(lambda: link.words)
    drive(link, times=3)
    assert robot.of("Twist") == [{"linear": 0.25}]
    link.zero()
    until(lambda: not link.zero_due)
    link.velocity(AHEAD)
    until(lambda: len(link.words) == 2)


def test_a_refusal_that_is_late_does_not_hold_the_next_drive(robot: ScriptedRobot, link: Link) -> None:
    """A zero was asked for meanwhile: what comes after it is another drive."""
    hold = threading.Event()
    robot.answers["Twist"] = lambda body: "manual" if body and hold.wait(5.0) else {}
    link.velocity(AHEAD)
    until(lambda: robot.of("Twist"))
    link.zero()
    hold.set()
    until(lambda: link.words and not link.zero_due)
    robot.answers["Twist"] = lambda body: {}
    robot.asked.clear()
    link.velocity(AHEAD)
    until(lambda: robot.of("Twist"))
    assert robot.of("Twist") == [{"linear": 0.25}]


def test_silence_is_that_of_prompt_requests_only(robot: ScriptedRobot, link: Link) -> None:
    robot.silent.set()
    link.post("woosh.map.SceneData")
    until(lambda: robot.of("SceneData"))
    assert link.silence == 0.0
    link.post(POSE, prompt=True)
    until(lambda: link.silence > LATE_SECONDS)


def test_after_a_lost_connection_zero_is_the_first_velocity(robot: ScriptedRobot, link: Link) -> None:
    drive(link)
    until(lambda: robot.of("Twist"))
    lost: list[Any] = []
    robot.answers["Battery"] = lambda _: None
    link.post("woosh.robot.Battery", done=lost.append)
    until(lambda: robot.of("Battery"))
    robot.asked.clear()
    robot.drop()
    until(lambda: [type(answer) for answer in lost] == [ConnectionLost])
    link.velocity(AHEAD)  # while it is away: never sent
    until(lambda: link.number == 2 and link.up and not link.zero_due)
    assert robot.of("Twist") == [{}] * 3
    assert POSE in robot.topics


def test_a_robot_that_leaves_too_many_requests_unanswered_is_given_up(
    robot: ScriptedRobot, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What waits for answers is bounded, although the robot answers what the bridge asks all the time."""
    monkeypatch.setattr(client, "MAX_OPEN", 5)
    robot.answers["Battery"] = lambda _: None
    ends: list[Any] = []
    for _ in range(6):
        link.post("woosh.robot.Battery", done=ends.append)
    until(lambda: [type(answer) for answer in ends] == [ConnectionLost] * 6)
    until(lambda: link.number == 2)
    assert link.ask(POSE)["mileage"] == 42


@pytest.mark.parametrize(
    "answer", [{"ok": 1}, {"ok": True, "body": {"power": "x"}}, {"ok": True, "type": "T"}]
)
def test_an_answer_that_does_not_fit_is_an_error(
    robot: ScriptedRobot, link: Link, monkeypatch: pytest.MonkeyPatch, answer: dict[str, Any]
) -> None:
    monkeypatch.setattr(
        robot, "_answer", lambda peer, frame: peer.send(json.dumps({**answer, "sn": frame.get("sn")}))
    )
    with pytest.raises(CodecError):
        link.ask("woosh.robot.Battery")


def test_a_request_that_a_robot_never_answers_is_forgotten(
    robot: ScriptedRobot, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot may be silent about one that it does not know: that is not the end of the link."""
    monkeypatch.setattr(client, "MAX_OPEN", 5)
    monkeypatch.setattr(client, "FORGET_SECONDS", 0.0)
    robot.answers["Speak"] = lambda _: None
    until(lambda: POSE in robot.topics)
    ends: list[Any] = []
    for number in range(1, 21):
        link.post("woosh.robot.Speak", {"text": "hello"}, ends.append)
        robot.push("PoseSpeed", {})
        until(lambda number=number: len(ends) == number)
    assert {type(answer) for answer in ends} == {RosTimeout}
    assert (len(ends), link.number) == (20, 1)


def test_a_close_during_a_new_connection_ends_it(
    robot: ScriptedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = Link(robot.port)
    connecting, cut, go_on, real = threading.Event(), threading.Event(), threading.Event(), client.connect

    def late(*args: Any, **options: Any) -> Any:
        connecting.set()
        go_on.wait(5.0)
        return real(*args, **options)

    link.start()
    until(lambda: POSE in robot.topics)  # the robot knows the connection, too
    monkeypatch.setattr(client, "connect", late)
    robot.drop()
    assert connecting.wait(5.0)
    monkeypatch.setattr(link, "cut", cut.set)  # the connection before: `close` cannot know the new one
    closing = threading.Thread(target=link.close)
    closing.start()
    assert cut.wait(5.0)
    go_on.set()
    closing.join(5.0)
    assert not threads_of_links()


def test_a_close_sends_the_zero_that_is_due(robot: ScriptedRobot) -> None:
    link = Link(robot.port)
    link.start()
    drive(link)
    until(lambda: robot.of("Twist"))
    link.close()
    assert {} in robot.of("Twist")
    assert not threads_of_links()
