"""Reads and writes the messages of the Foxglove WebSocket protocol. Pure.

A text message is JSON with an `op`; a binary message begins with an opcode and has little-endian numbers.
`read` checks a client's message and refuses a wrong one with a sentence.

Source: github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Annotated, NamedTuple

from rosproto.json_fields import MISSING, Anything, Check, FieldError, Reader, listed, shown, text, whole
from rosproto.json_text import JsonError, JsonReader
from rosproto.json_values import plain

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannel, AdvertisedService
    from rosproto.gateway.foxglove.graph import ConnectionGraph

SUBPROTOCOLS = "foxglove.sdk.v1", "foxglove.websocket.v1"
"""Two names of one protocol; viewers older than Foxglove's SDK know the second one."""

ENCODINGS = "json", "ros1"
"""Encodings in which clients may publish. Viewers choose the first: it needs no definition."""

ROS1, SCHEMA_ENCODING = "ros1", "ros1msg"


class Level(IntEnum):
    """The level of a status."""

    INFO = 0
    WARNING = 1
    ERROR = 2


class MessageError(ValueError):
    """A message of a client is not valid; the text is a sentence for the client."""


# -- requests of a client ------------------------------------------------------------------------------------


class Request:
    """One message of a client. Fields have the checks of their JSON values, see `rosproto.json_fields`."""

    __slots__ = ()


_number = whole(0, 2**32 - 1, "a whole number of 32 bits")
Number = Annotated[int, _number]
Text = Annotated[str, text]
Names = Annotated[tuple[str, ...], listed(text), "parameterNames"]


class ChannelSubscription(NamedTuple):
    """The client's subscription id, and the id of the channel."""

    id: Number
    channel: Annotated[Number, "channelId"]


@dataclass(frozen=True, slots=True)
class Subscribe(Request):
    subscriptions: Annotated[tuple[ChannelSubscription, ...], listed(Reader(ChannelSubscription))]


@dataclass(frozen=True, slots=True)
class Unsubscribe(Request):
    """Attributes:
    subscriptions: The client's subscription ids.
    """

    subscriptions: Annotated[tuple[int, ...], listed(_number), "subscriptionIds"]


@dataclass(frozen=True, slots=True)
class ClientAdvertisement:
    """A channel on which a client publishes.

    Attributes:
        id: The client's channel id.
        topic, encoding, schema_name: As the client gives them.
        schema: Definition of the type, or "".
        schema_encoding: Format of the definition.
    """

    id: Number
    topic: Text
    encoding: Text
    schema_name: Annotated[Text, "schemaName"]
    schema: Text = ""
    schema_encoding: Annotated[Text, "schemaEncoding"] = ""


@dataclass(frozen=True, slots=True)
class Advertise(Request):
    channels: Annotated[tuple[ClientAdvertisement, ...], listed(Reader(ClientAdvertisement))]


@dataclass(frozen=True, slots=True)
class Unadvertise(Request):
    """Attributes:
    channels: The client's channel ids.
    """

    channels: Annotated[tuple[int, ...], listed(_number), "channelIds"]


@dataclass(frozen=True, slots=True)
class GetParameters(Request):
    """Attributes:
    names: Parameters; empty for all.
    id: Id of the request, or None.
    """

    names: Names
    id: Text | None = None


class _Parameter(NamedTuple):
    name: Text
    value: Anything = None
    type: Anything = None


_read_parameter = Reader(_Parameter)


def _typed(document: object, max_characters: int) -> tuple[str, object]:
    """The name and value of a parameter; the value is None if it has none."""
    name, value, kind = _read_parameter(document, max_characters)
    if value is None or kind is None:
        return name, value
    try:
        if kind == "byte_array" and isinstance(value, str):
            return name, base64.b64decode(value, validate=True)
        if kind == "float64" and not isinstance(value, (str, bool)):
            return name, float(value)
        if kind == "float64_array" and isinstance(value, list):
            return name, [float(each) for each in value]
    except (binascii.Error, TypeError, ValueError, OverflowError):
        pass
    raise MessageError(f"the value of {shown(name)} is no {shown(kind)}")


@dataclass(frozen=True, slots=True)
class SetParameters(Request):
    """Attributes:
    parameters: (name, value); the value None deletes the parameter.
    id: Id of the request; None if no answer is wanted.
    """

    parameters: Annotated[tuple[tuple[str, object], ...], listed(_typed)]
    id: Text | None = None


@dataclass(frozen=True, slots=True)
class FollowParameters(Request):
    names: Names


@dataclass(frozen=True, slots=True)
class LeaveParameters(Request):
    """Attributes:
    names: Empty for all.
    """

    names: Names


@dataclass(frozen=True, slots=True)
class WantGraph(Request):
    wanted: bool


@dataclass(frozen=True, slots=True)
class FetchAsset(Request):
    uri: Text
    request: Annotated[Number, "requestId"]


@dataclass(frozen=True, slots=True)
class Publish(Request):
    channel: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Call(Request):
    service: int
    call: int
    encoding: str
    data: bytes


def read(data: str | bytes, reader: JsonReader) -> Request:
    """Read one message of a client.

    Raises:
        MessageError: It is not valid.
    """
    return _read_binary(data) if isinstance(data, bytes) else _read_text(data, reader)


def _read_text(text: str, reader: JsonReader) -> Request:
    try:
        values = reader.read(text)
    except JsonError as problem:
        raise MessageError(f"the message {problem}") from None
    document = values[0] if values else None
    if not isinstance(document, dict):
        raise MessageError("the message is not a JSON object")
    op = document.get("op", MISSING)
    read_fields = _OPERATIONS.get(op) if isinstance(op, str) else None
    if read_fields is None:
        raise MessageError(f"the message's op is {shown(op)}; expected one of {', '.join(_OPERATIONS)}")
    try:
        request: Request = read_fields(document, 0)
    except (FieldError, MessageError) as problem:
        raise MessageError(f"{op}: {problem}") from None
    return request


def _read_binary(data: bytes) -> Request:
    op = data[0] if data else None
    if op == 1 and len(data) >= 5:
        return Publish(_UINT32.unpack_from(data, 1)[0], data[5:])
    if op == 2 and len(data) >= 13:
        service, call, length = _THREE.unpack_from(data, 1)
        if length <= len(data) - 13:
            encoding = data[13 : 13 + length].decode("utf-8", "replace")
            return Call(service, call, encoding, data[13 + length :])
    if op not in (1, 2):
        raise MessageError(f"a binary message begins with {op}; expected 1, a message, or 2, a call")
    raise MessageError(f"a binary message of kind {op} ends too early, after {len(data)} bytes")


_UINT32, _THREE = struct.Struct("<I"), struct.Struct("<III")


_OPERATIONS: dict[str, Check[Request]] = {
    "subscribe": Reader(Subscribe),
    "unsubscribe": Reader(Unsubscribe),
    "advertise": Reader(Advertise),
    "unadvertise": Reader(Unadvertise),
    "getParameters": Reader(GetParameters),
    "setParameters": Reader(SetParameters),
    "subscribeParameterUpdates": Reader(FollowParameters),
    "unsubscribeParameterUpdates": Reader(LeaveParameters),
    "subscribeConnectionGraph": lambda _document, _limit: WantGraph(True),
    "unsubscribeConnectionGraph": lambda _document, _limit: WantGraph(False),
    "fetchAsset": Reader(FetchAsset),
}


# -- messages to a client ------------------------------------------------------------------------------------


def _document(op: str, **fields: object) -> str:
    return json.dumps({"op": op, **{name: value for name, value in fields.items() if value is not None}})


def server_info(name: str, capabilities: Sequence[str], session: str) -> str:
    """The first message; with a new session id, the viewer discards everything before."""
    return _document(
        "serverInfo", name=name, capabilities=capabilities, supportedEncodings=ENCODINGS, sessionId=session
    )


def status(text: str, level: Level, id: str | None = None) -> str:
    """A text to show; with an id it stays until `remove_status`."""
    return _document("status", level=level, message=text, id=id)


def remove_status(id: str) -> str:
    return _document("removeStatus", statusIds=[id])


def advertise(channels: Iterable[AdvertisedChannel]) -> str:
    return _document(
        "advertise",
        channels=[
            {
                "id": one.id,
                "topic": one.topic,
                "encoding": ROS1,
                **_schema(one.schema.type_name, one.schema.definition),
            }
            for one in channels
        ],
    )


def unadvertise(channels: Iterable[int]) -> str:
    return _document("unadvertise", channelIds=list(channels))


def advertise_services(services: Iterable[AdvertisedService]) -> str:
    return _document(
        "advertiseServices",
        services=[
            {
                "id": one.id,
                "name": one.name,
                "type": one.kind._type,
                "request": {
                    "encoding": ROS1,
                    **_schema(f"{one.kind._type}_Request", one.kind._request_class._full_text),
                },
                "response": {
                    "encoding": ROS1,
                    **_schema(f"{one.kind._type}_Response", one.kind._response_class._full_text),
                },
            }
            for one in services
        ],
    )


def _schema(name: str, definition: str) -> dict[str, str]:
    return {"schemaName": name, "schemaEncoding": SCHEMA_ENCODING, "schema": definition}


def unadvertise_services(services: Iterable[int]) -> str:
    return _document("unadvertiseServices", serviceIds=list(services))


def service_failure(asked: Call, text: str) -> str:
    return _document("serviceCallFailure", serviceId=asked.service, callId=asked.call, message=text)


def parameter_values(values: Iterable[tuple[str, object]], id: str | None = None) -> str:
    """Parameters with their values; None stands for one that is not set."""
    return _document("parameterValues", parameters=[_parameter(*one) for one in values], id=id)


def _parameter(name: str, value: object) -> dict[str, object]:
    if value is None:
        return {"name": name}
    if isinstance(value, bytes):
        return {"name": name, "value": base64.b64encode(value).decode("ascii"), "type": "byte_array"}
    if isinstance(value, float):
        return {"name": name, "value": plain(value), "type": "float64"}
    if isinstance(value, (list, tuple)) and value and all(isinstance(one, float) for one in value):
        return {"name": name, "value": plain(value), "type": "float64_array"}
    return {"name": name, "value": plain(value, octets=lambda octets: octets.decode("utf-8", "replace"))}


_Nodes = Mapping[str, Sequence[str]]


def graph_update(before: ConnectionGraph, now: ConnectionGraph) -> str:
    """The changes between two graphs."""

    def changed(
        old: _Nodes, new: _Nodes, ids: str, kept: Container[str] = ()
    ) -> list[dict[str, Sequence[str]]]:
        """The changed entries, with empty ones for names in `kept` that have no nodes left."""
        left = [name for name in old if name not in new and name in kept]
        return [{"name": name, ids: list(new[name])} for name in new if old.get(name) != new[name]] + [
            {"name": name, ids: []} for name in left
        ]

    topics = {*now.published, *now.subscribed}
    return _document(
        "connectionGraphUpdate",
        publishedTopics=changed(before.published, now.published, "publisherIds", topics),
        subscribedTopics=changed(before.subscribed, now.subscribed, "subscriberIds", topics),
        advertisedServices=changed(before.services, now.services, "providerIds"),
        removedTopics=sorted({*before.published, *before.subscribed} - topics),
        removedServices=sorted(set(before.services) - set(now.services)),
    )


def message_head(subscription: int, nanoseconds: int) -> bytes:
    """The header before the bytes of a topic's message."""
    return _MESSAGE.pack(1, subscription, nanoseconds)


def time(nanoseconds: int) -> bytes:
    return _TIME.pack(2, nanoseconds)


def service_response(asked: Call, data: bytes) -> bytes:
    encoding = asked.encoding.encode()
    return b"\x03" + _THREE.pack(asked.service, asked.call, len(encoding)) + encoding + data


def asset_head(request: int) -> bytes:
    """The header before the bytes of a file."""
    return _ASSET.pack(4, request, 0, 0)


def asset_failure(request: int, text: str) -> bytes:
    why = text.encode("utf-8", "replace")
    return _ASSET.pack(4, request, 1, len(why)) + why


_MESSAGE, _TIME, _ASSET = struct.Struct("<BIQ"), struct.Struct("<BQ"), struct.Struct("<BIBI")
