"""Fuzz targets of the rosbridge gateway: messages of clients, and the pictures that they may send."""

from __future__ import annotations

import base64
import json
from typing import Any

from rosproto.codec import define, encode, message_class
from rosproto.errors import CodecError
from rosproto.gateway import GatewayLimits
from rosproto.gateway.rosbridge.operations import (
    CallService,
    LongMessage,
    Publish,
    Reply,
    Request,
    SendActionGoal,
    SetLevel,
)
from rosproto.gateway.rosbridge.png import PngError, pack, unpack
from rosproto.gateway.rosbridge.protocol import Protocol
from rosproto.gateway.values import from_arguments, from_values, to_json
from rosproto.time import Time

LIMITS = GatewayLimits(message_bytes=1 << 13, nesting=20, text_length=100)
CLASSES = {
    "/cmd_vel": message_class("geometry_msgs/Twist"),
    "/pose": message_class("geometry_msgs/PoseWithCovarianceStamped"),
    "/joint": message_class("sensor_msgs/JointState"),
    "/image": message_class("sensor_msgs/CompressedImage"),
    "/odd": define(
        "a/Odd", "time t\nduration[2] d\nbool[] b\nchar[3] c\nint8 i\nuint64[] u\nfloat32 f\nstring[] s"
    ),
}
NOW = Time(7, 8)


def rosbridge(data: bytes) -> str:
    """Any message gives effects with bounded fields; as text, as bytes, in two steps, behind another the same."""
    requests = Protocol(LIMITS).receive(data)
    steps: list[Request] = []
    for request in Protocol(LIMITS).receive(data, at_once=True):
        steps += request.read() if isinstance(request, LongMessage) else [request]
    assert repr(steps) == repr(requests)
    text = data.decode("utf-8", "replace")
    if text.encode() == data and len(text) == len(data):
        assert repr(Protocol(LIMITS).receive(text)) == repr(requests)
    used = Protocol(LIMITS)
    for _ in range(3):
        for request in used.receive(data):
            _perform(used, request)
    return " ".join(_outcome(request) for request in requests[:3])


def _outcome(request: Request) -> str:
    if isinstance(request, Reply):
        answer = json.loads(request.payloads[0])
        return str(answer["msg"] if answer["op"] == "status" else answer["values"])
    return f"{type(request).__name__} {_as_message(request)}"


def _as_message(request: Request) -> str:
    """What a client sends for a message becomes one that has bytes, or is refused with a sentence."""
    try:
        if isinstance(request, Publish):
            cls = CLASSES.get(request.topic, CLASSES["/odd"])
            message = from_values(cls, request.msg, now=NOW)
        elif isinstance(request, (CallService, SendActionGoal)):
            message = from_arguments(CLASSES["/odd"], request.args)
        else:
            return ""
    except CodecError as error:
        return str(error)
    assert isinstance(json.loads(to_json(message)), dict)
    assert encode(message) is not None
    return "fits"


def _perform(protocol: Protocol, request: Request) -> None:
    """The answers to a call can be sent and read, whatever its names and sizes are."""
    if isinstance(request, CallService):
        payloads = protocol.service_failure(request, "no")
    elif isinstance(request, SendActionGoal):
        payloads = protocol.action_result(request, '{"a": 1}', 4)
    elif isinstance(request, SetLevel):
        payloads = protocol.status("info", request.level, request.id)
    else:
        return
    for payload in payloads:
        answer: Any = json.loads(payload)
        assert answer["op"]


def rosbridge_picture(data: bytes) -> str:
    """A picture is text or refused."""
    try:
        text = unpack(base64.b64encode(data).decode(), 1 << 14)
    except PngError as error:
        return str(error)
    return f"text of {len(text)}"


TARGETS = {"rosbridge": rosbridge, "rosbridge_picture": rosbridge_picture}
TOKENS = {
    "rosbridge": [
        *(
            f'"op":"{op}"'.encode()
            for op in (
                "advertise unadvertise publish subscribe unsubscribe call_service advertise_service "
                "unadvertise_service service_response send_action_goal cancel_action_goal advertise_action "
                "unadvertise_action action_feedback action_result auth set_level fragment png"
            ).split()
        ),
        *(
            f'"{name}":'.encode()
            for name in (
                "id topic type msg args values result service action action_type throttle_rate queue_length "
                "fragment_size compression latch queue_size timeout level data num total feedback mac status"
            ).split()
        ),
        *b'{ } [ ] , : "" "now" null true false -1 1e999 NaN Infinity 1.5 0 {"secs":1,"nsecs":2} "cbor-raw" "/odd"'.split(),
        *b'"/pose" "/joint" "header" "stamp" "linear" {"x":1} "AAA=" \\ud800 \\u0000 [[[[ ]]]] "t" "d" "b" "c" "i" "u" "f" "s"'.split(),
        pack("{}").encode(),
        b"\xff",
        b"9" * 400,
    ],
    "rosbridge_picture": [
        b"IHDR",
        b"IDAT",
        b"IEND",
        b"PLTE",
        b"\x89PNG\r\n\x1a\n",
        b"\0\0\0\x0d",
        b"\0\0\0\x01",
    ],
}
