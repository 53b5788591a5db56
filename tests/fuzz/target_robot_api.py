"""Fuzz target of the Robot API's server: requests of clients, each of which has an answer that JSON can hold."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import cast

from rosproto.json_text import JsonError, JsonReader
from woosh_pure.api_server.session import respond
from woosh_pure.api_server.state import ApiState
from woosh_pure.robot_api import wire

READER = JsonReader(200, 20)
STATE = cast(ApiState, SimpleNamespace(answer=lambda kind, asked: {}))


def robot_api(data: bytes) -> str:
    """One request; a body is also read as each kind of message that it names, and written again."""
    try:
        documents = READER.read(data)
    except JsonError:
        return "no JSON"
    frame = documents[0] if documents else None
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


TARGETS = {"robot_api": robot_api}
