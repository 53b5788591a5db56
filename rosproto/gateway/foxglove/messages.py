"""Reads and writes the messages of the Foxglove WebSocket protocol. Pure.

A text message is JSON with an `op`; a binary message begins with an opcode and has little-endian numbers.
`read` checks a client's message and refuses a wrong one with a sentence.

Source: docs/spec.md of github.com/foxglove/ws-protocol.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from rosproto.gateway.json_text import JsonError, JsonReader
from rosproto.json_values import plain

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannel, AdvertisedService
    from rosproto.gateway.foxglove.graph import ConnectionGraph

SUBPROTOCOLS = "foxglove.sdk.v1", "foxglove.websocket.v1"
"""Two names of one protocol; viewers older than Foxglove's SDK know the second one."""

ENCODINGS = "json", "ros1"
"""Encodings in which clients may publish. Viewers choose the first: it needs no definition."""

ROS1, SCHEMA_ENCODING = "ros1", "ros1msg"
_SHOWN = 40  # characters of a client's text in a sentence


class Level(IntEnum):
    """The level of a status."""

    INFO = 0
    WARNING = 1
    ERROR = 2


class MessageError(ValueError):
    """A message of a client is not valid; the text is a sentence for the client."""


# -- requests of a client ------------------------------------------------------------------------------------


class Request:
    """One message of a client."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Subscribe(Request):
    """Attributes:
    subscriptions: (the client's subscription id, channel id).
    """

    subscriptions: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Unsubscribe(Request):
    """Attributes:
    subscriptions: The client's subscription ids.
    """

    subscriptions: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ClientAdvertisement:
    """A channel on which a client publishes.

    Attributes:
        id: The client's channel id.
        topic, encoding, schema_name: As the client gives them.
        schema: Definition of the type, or "".
        schema_encoding: Format of the definition.
    """

    id: int
    topic: str
    encoding: str
    schema_name: str
    schema: str = ""
    schema_encoding: str = ""


@dataclass(frozen=True, slots=True)
class Advertise(Request):
    channels: tuple[ClientAdvertisement, ...]


@dataclass(frozen=True, slots=True)
class Unadvertise(Request):
    """Attributes:
    channels: The client's channel ids.
    """

    channels: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class GetParameters(Request):
    """Attributes:
    names: Parameters; empty for all.
    id: Id of the request, or None.
    """

    names: tuple[str, ...]
    id: str | None = None


@dataclass(frozen=True, slots=True)
class SetParameters(Request):
    """Attributes:
    parameters: (name, value); the value None deletes the parameter.
    id: Id of the request; None if no answer is wanted.
    """

    parameters: tuple[tuple[str, object], ...]
    id: str | None = None


@dataclass(frozen=True, slots=True)
class FollowParameters(Request):
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LeaveParameters(Request):
    """Attributes:
    names: Empty for all.
    """

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WantGraph(Request):
    wanted: bool


@dataclass(frozen=True, slots=True)
class FetchAsset(Request):
    uri: str
    request: int


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
        raise MessageError("the message is no JSON object")
    op = document.get("op")
    read_fields = _OPERATIONS.get(op) if isinstance(op, str) else None
    if read_fields is None:
        raise MessageError(f"the message's op is {_short(op)}; expected one of {', '.join(_OPERATIONS)}")
    try:
        return read_fields(document)
    except MessageError as problem:
        raise MessageError(f"{op}: {problem}") from None


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


def _text(document: Mapping[str, Any], name: str, default: str | None = None) -> str:
    value = document.get(name)
    if value is None and default is not None:
        return default
    if not isinstance(value, str):
        raise MessageError(f"{name} is {_short(value)}; expected a text")
    return value


def _number(value: object, name: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 32:
        raise MessageError(f"{name} is {_short(value)}; expected a whole number of 32 bits")
    return value


def _list(document: Mapping[str, Any], name: str, kind: type = object, what: str = "") -> list[Any]:
    value = document.get(name)
    if not isinstance(value, list):
        raise MessageError(f"{name} is {_short(value)}; expected a list")
    if not all(isinstance(one, kind) for one in value):
        raise MessageError(f"{name} has what is no {what}")
    return value


def _objects(document: Mapping[str, Any], name: str) -> list[dict[str, Any]]:
    return _list(document, name, dict, "object")


def _numbers(document: Mapping[str, Any], name: str) -> tuple[int, ...]:
    return tuple(_number(one, name) for one in _list(document, name))


def _names(document: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(_list(document, "parameterNames", str, "text"))


def _id(document: Mapping[str, Any]) -> str | None:
    return None if document.get("id") is None else _text(document, "id")


def _subscribe(document: Mapping[str, Any]) -> Request:
    return Subscribe(
        tuple(
            (_number(one.get("id"), "id"), _number(one.get("channelId"), "channelId"))
            for one in _objects(document, "subscriptions")
        )
    )


def _advertise(document: Mapping[str, Any]) -> Request:
    return Advertise(
        tuple(
            ClientAdvertisement(
                _number(one.get("id"), "id"),
                _text(one, "topic"),
                _text(one, "encoding"),
                _text(one, "schemaName"),
                _text(one, "schema", ""),
                _text(one, "schemaEncoding", ""),
            )
            for one in _objects(document, "channels")
        )
    )


def _set_parameters(document: Mapping[str, Any]) -> Request:
    parameters = tuple((_text(one, "name"), _value(one)) for one in _objects(document, "parameters"))
    return SetParameters(parameters, _id(document))


def _value(one: Mapping[str, Any]) -> object:
    """The value of a client's parameter; None if it has none."""
    value, kind = one.get("value"), one.get("type")
    if value is None or kind is None:
        return value
    try:
        if kind == "byte_array" and isinstance(value, str):
            return base64.b64decode(value, validate=True)
        if kind == "float64" and not isinstance(value, (str, bool)):
            return float(value)
        if kind == "float64_array" and isinstance(value, list):
            return [float(each) for each in value]
    except (binascii.Error, TypeError, ValueError, OverflowError):
        pass
    raise MessageError(f"the value of {_short(one.get('name'))} is no {_short(kind)}")


_OPERATIONS: dict[str, Callable[[Mapping[str, Any]], Request]] = {
    "subscribe": _subscribe,
    "unsubscribe": lambda document: Unsubscribe(_numbers(document, "subscriptionIds")),
    "advertise": _advertise,
    "unadvertise": lambda document: Unadvertise(_numbers(document, "channelIds")),
    "getParameters": lambda document: GetParameters(_names(document), _id(document)),
    "setParameters": _set_parameters,
    "subscribeParameterUpdates": lambda document: FollowParameters(_names(document)),
    "unsubscribeParameterUpdates": lambda document: LeaveParameters(_names(document)),
    "subscribeConnectionGraph": lambda document: WantGraph(True),
    "unsubscribeConnectionGraph": lambda document: WantGraph(False),
    "fetchAsset": lambda document: FetchAsset(
        _text(document, "uri"), _number(document.get("requestId"), "requestId")
    ),
}


def _short(value: object) -> str:
    if value is None:
        return "missing"
    text = repr(value[:_SHOWN] if isinstance(value, str) else value)
    return text if len(text) <= 2 * _SHOWN else f"{text[: 2 * _SHOWN]}..."


# -- messages to a client ------------------------------------------------------------------------------------


def _document(op: str, **fields: Any) -> str:
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


def _parameter(name: str, value: object) -> dict[str, Any]:
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

    def changed(old: _Nodes, new: _Nodes, ids: str, kept: Container[str] = ()) -> list[dict[str, Any]]:
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
