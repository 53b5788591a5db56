"""`ApiSession` and the site, without a network: what waits for a client that reads slowly."""

from __future__ import annotations

import asyncio
import json
import sys
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from rosproto.gateway import ClientChannel, GatewayLimits, Refused
from rosproto.json_text import JsonReader
from rosproto.json_values import JsonValue
from woosh_pure.api_server.session import ApiPosts, ApiSession, respond
from woosh_pure.api_server.site import RobotSite
from woosh_pure.api_server.state import SCANNER, ApiState
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import UserMark
from woosh_pure.robot_api import wire

POSE = "woosh.robot.PoseSpeed"


@pytest.fixture
def session() -> ApiSession:
    """Its channel is never emptied."""
    nothing: Any = lambda *_: None  # noqa: E731
    made = ApiSession(
        cast(ApiState, SimpleNamespace(limits=GatewayLimits())),
        ClientChannel("peer", GatewayLimits(), nothing, nothing, nothing),
    )
    made.topics = frozenset({POSE, SCANNER})
    return made


def test_a_slow_client_gets_the_newest_value_of_each_topic(session: ApiSession) -> None:
    for number in range(100):
        session.push(POSE, f"pose {number}")
        session.push(SCANNER, f"scan {number}")
    assert [session.channel.outbox.take() for _ in range(3)] == ["pose 99", "scan 99", None]


def test_an_equal_value_is_not_pushed_again_but_every_scan_is(session: ApiSession) -> None:
    sent = []
    for _ in range(2):
        session.push(POSE, "pose")
        session.push(SCANNER, "scan")
        session.push("woosh.robot.Mode", "a topic of somebody else")
        session.push(POSE, None)
        while (text := session.channel.outbox.take()) is not None:
            sent.append(text)
    assert sent == ["pose", "scan", "scan"]


def test_what_waits_of_a_topic_that_was_left_is_not_sent(session: ApiSession) -> None:
    """And after subscribing again the present value comes once more."""
    session.push(POSE, "pose")
    session.forget(POSE)
    assert session.channel.outbox.take() is None
    session.push(POSE, "pose")
    assert session.channel.outbox.take() == "pose"


def test_a_request_is_answered_whatever_carried_it() -> None:
    """By HTTP its path is the type, and its body that of the message alone."""
    reader = JsonReader(100, 20)

    async def read_json(data: bytes) -> JsonValue:
        return reader.one(data)

    state = cast(
        ApiState,
        SimpleNamespace(
            answer=lambda kind, asked: {"ctrl": 1, "work": 2}, waits=lambda *_: False, read_json=read_json
        ),
    )
    answer = {"type": "woosh.robot.Mode", "body": {"ctrl": 1, "work": 2}, "ok": True, "msg": ""}
    assert respond(state, {"type": "woosh.robot.Mode"}, "a client") == answer

    def post(path: str, data: bytes) -> tuple[int, object]:
        status, text = asyncio.run(ApiPosts(state).answer(path, data, "10.0.0.9"))
        return status, json.loads(text)

    for data in (b"", b"{}", b"null", b'{"robotId": 9, "sn": 5}'):
        assert post("/woosh/robot/Mode", data) == (200, answer)
    refused = {"type": "woosh.robot.Mode", "body": {}, "ok": False}
    assert post("/woosh/robot/Mode", b"{") == (
        200,
        {
            **refused,
            "msg": "the body is not JSON: Expecting property name enclosed in double quotes at character 1",
        },
    )
    for path in ("/woosh/robot/What", "/woosh/robot/Mode/", "//woosh/robot/Mode", "", "*", "/" + "x" * 5000):
        status, found = post(path, b"{}")
        assert isinstance(found, dict)
        assert (status, found["ok"], "; one is /woosh/robot/Battery" in found["msg"]) == (404, False, True)
        assert found["type"] == ""


@pytest.mark.parametrize("kind", ["PlanNavPath", "ScannerData", "ExecTask"])
def test_what_comes_after_a_request_that_waits_for_the_robot_is_read_meanwhile(kind: str) -> None:
    """It may be a stop."""
    waiting: list[object] = []

    async def read_json(data: str) -> JsonValue:
        return cast(JsonValue, json.loads(data))

    state = SimpleNamespace(
        limits=GatewayLimits(),
        read_json=read_json,
        waits=lambda *_: True,
        pool=SimpleNamespace(spawn=waiting.append),
    )
    nothing: Any = lambda *_: None  # noqa: E731
    session = ApiSession(
        cast(ApiState, state), ClientChannel("peer", GatewayLimits(), nothing, nothing, nothing)
    )
    asyncio.run(session.received(json.dumps({"type": f"woosh.robot.{kind}"})))
    assert len(waiting) == 1


@pytest.mark.parametrize("leaves", [False, True])
def test_zero_follows_a_velocity_that_waited_until_its_client_had_gone(leaves: bool) -> None:
    gone: list[object] = []
    nothing: Any = lambda *_: None  # noqa: E731
    channel = ClientChannel("peer", GatewayLimits(), nothing, nothing, nothing)

    async def read_json(data: str) -> JsonValue:
        return cast(JsonValue, json.loads(data))

    def later(work: Any) -> None:
        channel.gone = leaves
        work()

    state = SimpleNamespace(
        limits=GatewayLimits(),
        read_json=read_json,
        waits=lambda *_: True,
        commands=SimpleNamespace(do=lambda *_: {}, gone=gone.append),
        pool=SimpleNamespace(spawn=later),
    )
    session = ApiSession(cast(ApiState, state), channel)
    asyncio.run(session.received(json.dumps({"type": "woosh.robot.Twist", "body": {"linear": 0.2}})))
    assert gone == ([session] if leaves else [])


def test_marks_without_a_pose_are_named_without_one() -> None:
    site = RobotSite(
        "hall",
        "ground",
        lambda: GridMap(np.zeros((2, 2), np.int8), 0.5),
        lambda: [UserMark("A 1", note="shelf"), UserMark("充", Pose2D(1.0, 2.0, 3.0), charger=True)],
    )
    answers = site.answers()
    (easy,) = wire.dump("woosh.map.SceneDataEasy", answers["woosh.map.SceneDataEasy"]({"name": "hall"}))[
        "maps"
    ]
    (base,) = easy["storages"]["bases"]
    assert (base["identity"]["no"], base["identity"]["desc"], "pose" in base) == ("A 1", "shelf", False)
    (charger,) = easy["storages"]["chargers"]
    assert charger["pose"]["dock"] == charger["pose"]["real"] == {"x": 1.0, "y": 2.0, "theta": 3.0}
    json.dumps(
        wire.dump("woosh.map.SceneData", answers["woosh.map.SceneData"]({"name": ""})), allow_nan=False
    )
    with pytest.raises(Refused, match="no scene 'other'; there is: hall"):
        answers["woosh.map.SceneData"]({"name": "other"})


def test_without_websockets_it_names_the_extra(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a sentence, and not as a traceback."""
    from woosh_pure.cli import main

    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    assert main(["sim", "--port", "0", "--robot-api", "0", "--for", "0"]) == 1
    assert 'pip install ".[api]"' in capsys.readouterr().err


def test_a_port_in_use_is_told_with_the_option_that_changes_it(capsys: pytest.CaptureFixture[str]) -> None:
    import socket

    from tests.support.extras import needs
    from woosh_pure.cli import main

    needs("api")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["sim", "--port", "0", "--robot-api", str(port), "--for", "0"]) == 1
    assert f"listen on 127.0.0.1:{port}" in (said := capsys.readouterr().err)
    assert "choose another --robot-api (0: a free one)" in said
