"""Fuzz targets of the Robot API's server: requests of clients, each of which has an answer that JSON can hold."""

from __future__ import annotations

import asyncio
import json
from types import SimpleNamespace
from typing import cast

from rosproto.codec import encode
from rosproto.json_text import JsonError, JsonReader
from rosproto.json_values import JsonValue
from woosh_pure.api_server.session import ApiPosts, respond
from woosh_pure.api_server.state import ApiState
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.commands import to_ros

READER = JsonReader(200, 20)


async def read_json(data: bytes) -> JsonValue:
    return READER.one(data)


def do(client: object, kind: str, asked: wire.Values, received: float) -> wire.Values:
    """A command becomes a message of ROS 1, or is refused."""
    encode(to_ros(kind, asked)[1])
    return {}


STATE = cast(
    ApiState,
    SimpleNamespace(
        answer=lambda kind, asked: {},
        waits=lambda *_: False,
        read_json=read_json,
        commands=SimpleNamespace(do=do),
    ),
)


def robot_api(data: bytes) -> str:
    """One request; a body is also read as each kind of message that it names, and written again."""
    try:
        frame = READER.one(data)
    except JsonError:
        return "no JSON"
    answer = respond(STATE, frame, "a client")
    json.dumps(answer, allow_nan=False)
    assert "internal error" not in answer["msg"]
    kind = frame.get("type") if isinstance(frame, dict) else None
    if kind in wire.messages():
        try:
            values = wire.load(kind, frame.get("body"))
        except ValueError:
            return "wrong body"
        json.dumps(wire.dump(kind, values), allow_nan=False)
        return str(kind)
    return "refused"


def robot_api_post(data: bytes) -> str:
    """One request by HTTP: its path, a line break, its body."""
    path, _, body = data.partition(b"\n")
    status, text = asyncio.run(ApiPosts(STATE).answer(path.decode("latin-1"), body, "10.0.0.9"))
    answer = json.loads(text)
    assert set(answer) == {"type", "body", "ok", "msg"}
    assert "internal error" not in answer["msg"]
    return f"{status.value} {answer['ok']}"


TARGETS = {"robot_api": robot_api, "robot_api_post": robot_api_post}
