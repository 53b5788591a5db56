"""Encodes rosbridge's `cbor` and `cbor-raw`: binary messages, with arrays of numbers as in RFC 8746.

Source: `rosbridge_library.internal.cbor_conversion` (rosbridge_suite, branch ros1), with the same bytes from
the package cbor2. The original fails at `T[N]`, `string[]` and `time[]`; here the first is written as `T[]`,
the others as lists.
"""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from types import ModuleType
from typing import Any
from weakref import WeakKeyDictionary

from rosproto.codec import decode, encode
from rosproto.codec.layout import DTYPES, FieldLayout
from rosproto.codec.message import Message
from rosproto.errors import RosError
from rosproto.extras import optional_module
from rosproto.gateway.chunks import ChunkedMessage, framed
from rosproto.gateway.json_writer import Writer
from rosproto.time import TVal

TAGS = {"H": 69, "I": 70, "Q": 71, "b": 72, "h": 77, "i": 78, "q": 79, "f": 85, "d": 86}
"""RFC 8746's numbers for arrays of these struct codes, little-endian. Octets are a byte string."""
_BYTE_STRING = 2
"""CBOR's major type of a byte string."""


class MissingLibrary(RosError, ImportError):
    """cbor2 is not installed; the text names the extra."""


_writers: WeakKeyDictionary[type[Message], Callable[[Message], dict[str, object]]] = WeakKeyDictionary()


def publish_cbor(topic: str, message: Message) -> bytes:
    """The operation `publish` with a topic's message, as CBOR.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    return dumps({"op": "publish", "topic": topic, "msg": to_cbor(message)})


def publish_cbor_raw(topic: str, secs: int, nsecs: int, data: bytes | memoryview) -> bytes | ChunkedMessage:
    """The operation `publish` with the serialized bytes of a topic's message; long ones are not copied.

    Args:
        topic: Name of the topic.
        secs: ROS time of its arrival, seconds.
        nsecs: And nanoseconds.
        data: The serialized message.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    message = {"secs": secs, "nsecs": nsecs, "bytes": b""}
    head = BytesIO()
    head.write(dumps({"op": "publish", "topic": topic, "msg": message})[:-1])  # without the length of b""
    _library().CBOREncoder(head).encode_length(_BYTE_STRING, len(data))
    return framed(head.getvalue(), data)


def to_cbor(message: Message) -> dict[str, object]:
    """The values of a message, for `dumps`."""
    cls = type(message)
    write = _writers.get(cls)
    if write is None:
        assert cls._binding is not None
        write = _writers[cls] = CborWriter().function(cls._binding.layout)
    try:
        return write(message)
    except (AttributeError, BufferError, TypeError, ValueError):
        return write(decode(cls, encode(message)))  # as in `values.to_json`


def dumps(value: object) -> bytes:
    """Encode values.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    try:
        data: bytes = _library().dumps(value)
    except UnicodeEncodeError:  # a robot's text that was not UTF-8
        data = _library().dumps(_encodable(value))
    return data


def _encodable(value: object) -> object:
    """The same values with a question mark for characters that UTF-8 cannot encode."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, dict):
        return {key: _encodable(item) for key, item in value.items()}
    return [_encodable(item) for item in value] if isinstance(value, list) else value


def _library() -> ModuleType:
    missing = 'compression cbor and cbor-raw need the package cbor2: pip install ".[bridge]"'
    return optional_module("cbor2", MissingLibrary(missing))


class CborWriter(Writer[dict[str, object]]):
    """Generates functions that return dicts."""

    def __init__(self) -> None:
        tag = _library().CBORTag

        def array(number: int, dtype: str, values: object) -> object:
            return tag(number, _bytes(values, dtype))

        super().__init__(
            {"array": array, "list": list, "map": map, "octets": _octets, "time": _time, "truth": bool}
        )

    def run(self, pieces: list[tuple[str, str]], *, first: bool) -> str:
        return "{" + ", ".join(f'"{name}": {expression}' for name, expression in pieces) + "}"

    def join(self, names: list[str]) -> str:
        return " | ".join(names)

    def one(self, field: FieldLayout, value: str) -> str:
        return f"time({value})" if field.kind == "time" else value

    def many(self, field: FieldLayout, value: str) -> str:
        if field.kind == "number" and field.code in TAGS:
            return f'array({TAGS[field.code]}, "{DTYPES[field.base]}", {value})'
        if field.code == "B":
            return f"octets({value})"
        call = {"time": "time", "number": "truth"}.get(field.kind)
        return f"list(map({call}, {value}))" if call else f"list({value})"

    def messages(self, call: str, value: str) -> str:
        return f"list(map({call}, {value}))"


def _time(value: TVal) -> dict[str, int]:
    return {"secs": value.secs, "nsecs": value.nsecs}


def _octets(values: object) -> bytes:
    return values if type(values) is bytes else _bytes(values, "u1")


def _bytes(values: Any, dtype: str) -> bytes:
    """The bytes of a numpy array; TypeError for a list or another dtype, which the codec converts."""
    if getattr(values, "dtype", None) != dtype:
        raise TypeError(dtype)
    data: bytes = values.tobytes()
    return data
