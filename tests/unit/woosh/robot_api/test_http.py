"""`ApiRequests`: one question has one deadline and one answer, whatever the robot does."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

import pytest

from rosproto.errors import CodecError, ConnectionLost, RemoteProtocolError, RosError, RosTimeout
from tests.support.robot_api_peer import ANSWERS, PASSWORD, ApiPeer, Refused, endless, half, silent
from woosh_pure.errors import ApiRefused
from woosh_pure.robot_api import http
from woosh_pure.robot_api.http import ApiAddress, ApiRequests, api_address

STATE, SCENE = "woosh.robot.RobotState", "woosh.robot.Scene"


def requests_to(peer: ApiPeer) -> ApiRequests:
    return ApiRequests(api_address(peer.address))


def with_script(script: Callable[[str, dict[str, Any]], Any], request: str = SCENE) -> ApiPeer:
    return ApiPeer({**ANSWERS, request: script})


@pytest.mark.parametrize(
    ("given", "address"),
    [
        ("", ApiAddress("robot", 5480)),
        ("10.0.0.7", ApiAddress("10.0.0.7", 5480)),
        ("10.0.0.7:80", ApiAddress("10.0.0.7", 80)),
        ("[::1]:81", ApiAddress("::1", 81)),
        ("me:se:c@ret@host:1", ApiAddress("host", 1, "me", "se:c@ret")),
    ],
)
def test_an_address_is_read(given: str, address: ApiAddress) -> None:
    assert api_address(given, "robot") == address


@pytest.mark.parametrize(
    "given", ["host:port", "host:70000", "me@host:1", ":pw@host", "a b", "http://host:1", "[::1"]
)
def test_what_is_not_an_address_is_refused_without_showing_a_password(given: str) -> None:
    with pytest.raises(ValueError, match="expected host:port, or user:password@host:port") as refused:
        api_address(given)
    assert "pw" not in str(refused.value)


def test_the_password_is_sent_and_not_shown() -> None:
    with ApiPeer(password=PASSWORD) as peer:
        requests = requests_to(peer)
        assert requests.ask(SCENE)["mapName"] == "ground"
        assert "word" not in repr(requests)


def test_a_robot_that_wants_a_password_is_named_once_with_the_remedy(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with ApiPeer(password=PASSWORD) as peer:
        requests = ApiRequests(ApiAddress("127.0.0.1", peer.port))
        with pytest.raises(ApiRefused, match="give robot_api='user:password@host:port'") as refused:
            requests.ask(SCENE)
        assert refused.value.status == 401
        with pytest.raises(ConnectionLost, match="not asked again for"):
            requests.ask(SCENE)
        assert peer.requests == ["RobotState"]
    warnings = [record for record in caplog.records if record.levelno == logging.WARNING]
    assert len(warnings) == 1


def test_questions_share_one_connection() -> None:
    with ApiPeer() as peer:
        requests = requests_to(peer)
        for _ in range(5):
            requests.ask(SCENE)
        assert (peer.connections, peer.requests) == (1, ["RobotState", *["Scene"] * 5])


def test_a_refusal_has_the_robots_words_without_control_characters() -> None:
    def refuse(request: str, body: dict[str, Any]) -> Any:
        raise Refused("机器人忙\x1b[2J")

    with with_script(refuse) as peer, pytest.raises(ApiRefused) as refused:
        requests_to(peer).ask(SCENE)
    assert str(refused.value) == "woosh.robot.Scene was refused: 机器人忙\\x1b[2J"
    assert (refused.value.robot_text, refused.value.exit_code) == ("机器人忙\x1b[2J", 3)


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ({"sceneName": 5}, "sceneName: .*expected a text"),
        ({"version": [1]}, "version: .*expected a whole number"),
        ([1, 2], "expected an object"),
        ({"sceneName": [[[]]] * 60_000}, "at most 100000 are accepted"),
        (b'HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\n{"a":', "is not JSON"),
        (b"HTTP/1.1 500 Oh\r\nContent-Length: 2\r\n\r\n{}", "HTTP 500"),
        (b'HTTP/1.1 200 OK\r\nContent-Length: 28\r\n\r\n{"ok":true,"type":"x\\u001b"}', r"type x\\x1b"),
        (b"SSH-2.0-OpenSSH\r\n\r\n", "status line"),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n", "more than 33554432 bytes"),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 60\r\n\r\n" + b"[" * 60, "not JSON"),
    ],
)  # fmt: skip
def test_an_answer_that_does_not_fit_is_an_error_that_says_where(body: object, text: str) -> None:
    with with_script(lambda *_: body) as peer, pytest.raises(RemoteProtocolError, match=text):
        requests_to(peer).ask(SCENE)


def test_an_endless_body_ends_at_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = http.Limits
    monkeypatch.setattr(http, "Limits", lambda **_: limits(xml_body_bytes=1 << 18))
    with with_script(endless) as peer, pytest.raises(RemoteProtocolError, match="more than 262144 bytes"):
        requests_to(peer).ask(SCENE)


@pytest.mark.parametrize("script", [half, lambda *_: b"HTTP/1.1 200", lambda *_: b"x"[:0]])
def test_a_robot_that_dies_in_between_is_an_error(script: Any) -> None:
    with with_script(script) as peer, pytest.raises((ConnectionLost, RemoteProtocolError)):
        requests_to(peer).ask(SCENE)


def test_a_silent_robot_costs_one_short_question_in_a_minute() -> None:
    with with_script(silent, STATE) as peer:
        requests = requests_to(peer)
        with pytest.raises(RosTimeout):
            requests.ask(SCENE, timeout=0.2)
        for _ in range(10):
            with pytest.raises(ConnectionLost, match=r"no answer within .*not asked again for"):
                requests.ask(SCENE, timeout=30.0)
        assert peer.requests == ["RobotState"]


def test_the_first_question_is_short_whatever_the_caller_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "FIRST_SECONDS", 0.1)
    with with_script(silent, STATE) as peer, pytest.raises(RosTimeout, match=r"0\.1 s"):
        requests_to(peer).ask(SCENE, timeout=600.0)


def test_an_answer_that_comes_in_drops_ends_at_the_deadline() -> None:
    """The deadline counts all steps: a piece now and then does not prolong it."""
    with with_script(endless) as peer:
        peer.pause = 0.02
        requests = requests_to(peer)
        with pytest.raises(RosTimeout, match=r"within 0\.3 s"):
            requests.ask(SCENE, timeout=0.3)


def test_a_robot_that_comes_back_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "PAUSE_SECONDS", 0.0)
    dead = with_script(lambda *_: b"x"[:0], STATE)
    with dead as peer:
        requests = requests_to(peer)
        with pytest.raises(ConnectionLost):
            requests.ask(SCENE)
        peer.answers[STATE] = ANSWERS[STATE]
        assert requests.ask(SCENE)["mapName"] == "ground"


def test_a_kept_connection_that_was_closed_is_replaced_for_reads() -> None:
    with ApiPeer() as peer:
        requests = requests_to(peer)
        requests.ask(SCENE)
        peer.drop()
        assert requests.ask(SCENE)["mapName"] == "ground"
        assert peer.connections == 2


def test_what_changes_something_is_never_sent_twice() -> None:
    """Whether the first one was carried out is not known when its answer does not come."""
    with with_script(lambda *_: b"x"[:0], "woosh.robot.SwitchMap") as peer:
        requests = requests_to(peer)
        requests.ask(SCENE)
        with pytest.raises(ConnectionLost):
            requests.ask("woosh.robot.SwitchMap", {"sceneName": "hall"})
        assert peer.requests == ["RobotState", "Scene", "SwitchMap"]


def test_callers_take_turns_within_their_own_time() -> None:
    began, go_on = threading.Event(), threading.Event()

    def slow(request: str, body: dict[str, Any]) -> Any:
        began.set()
        go_on.wait(30.0)
        return ANSWERS[SCENE]

    with with_script(slow) as peer:
        requests = requests_to(peer)
        first = threading.Thread(target=requests.ask, args=(SCENE,), kwargs={"timeout": 30.0})
        first.start()
        assert began.wait(10.0)
        with pytest.raises(RosTimeout):
            requests.ask(STATE, timeout=0.05)
        go_on.set()
        first.join(10.0)
        assert requests.ask(STATE)["state"] == 2, (
            "the time that another caller took is no failure of the robot"
        )


def test_an_unknown_request_or_field_is_not_sent() -> None:
    with ApiPeer() as peer:
        requests = requests_to(peer)
        for request, body in (("woosh.robot.Nothing", {}), (SCENE, {"wrong": 1})):
            with pytest.raises(CodecError):
                requests.ask(request, body)
        assert peer.asked == []


def test_closing_ends_a_question_under_way() -> None:
    began = threading.Event()
    problems: list[RosError] = []

    def hold(request: str, body: dict[str, Any]) -> None:
        began.set()

    def ask() -> None:
        try:
            requests.ask(SCENE, timeout=30.0)
        except RosError as error:
            problems.append(error)

    with with_script(hold) as peer:
        requests = requests_to(peer)
        asker = threading.Thread(target=ask)
        asker.start()
        assert began.wait(10.0)
        requests.close()
        asker.join(10.0)
        assert not asker.is_alive()
        assert isinstance(problems[0], ConnectionLost)
