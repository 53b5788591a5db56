"""rosbridge's `cbor` and `cbor-raw`: binary messages, arrays of numbers as typed arrays of RFC 8746.

Source: `rosbridge_library.internal.cbor_conversion` (rosbridge_suite, branch ros1). Of `T[N]`, `string[]` and
`time[]`, at which that raises an error, the first is written as `T[]`, the others as lists. The bytes are
those of the package cbor2.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from io import SEEK_END, BytesIO
from typing import Any
from weakref import WeakKeyDictionary

from rosproto.codec import decode, encode
from rosproto.codec.layout import DTYPES, FieldLayout
from rosproto.errors import RosError
from rosproto.gateway.chunks import CHUNK_SIZE, ChunkedMessage
from rosproto.gateway.json_writer import Writer

TAGS = {"H": 69, "I": 70, "Q": 71, "b": 72, "h": 77, "i": 78, "q": 79, "f": 85, "d": 86}
"""RFC 8746's numbers for arrays of these struct codes, little-endian. Octets are a byte string."""
_BYTE_STRING = 2
"""CBOR's major type of it."""


class MissingLibrary(RosError, ImportError):
    """cbor2 is not installed; names the extra it belongs to."""


_writers: WeakKeyDictionary[type, Callable[[Any], Any]] = WeakKeyDictionary()


def publish_cbor(topic: str, message: Any) -> bytes:
    """The binary message that brings a topic's message to a client.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    return dumps({"op": "publish", "topic": topic, "msg": to_cbor(message)})


def publish_cbor_raw(topic: str, secs: int, nsecs: int, data: bytes | bytearray | memoryview) -> bytes:
    """The binary message with a topic's message as ROS has it on the wire.

    Args:
        topic: Its name.
        secs: Of the ROS clock when it came.
        nsecs: The rest of that.
        data: The serialized message.
    """
    raw = data if isinstance(data, bytes) else bytes(data)
    return dumps({"op": "publish", "topic": topic, "msg": {"secs": secs, "nsecs": nsecs, "bytes": raw}})


def publish_cbor_raw_chunks(topic: str, secs: int, nsecs: int, data: bytes | memoryview) -> ChunkedMessage:
    """The same of a long message, whose bytes are not copied: they stand at the end of it.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    raw = memoryview(data)
    out = BytesIO(publish_cbor_raw(topic, secs, nsecs, b"")[:-1])  # but for the length, which is none
    out.seek(0, SEEK_END)
    _library().CBOREncoder(out).encode_length(_BYTE_STRING, len(raw))
    parts: list[bytes | memoryview] = [out.getvalue()]
    parts += (raw[at : at + CHUNK_SIZE] for at in range(0, len(raw), CHUNK_SIZE))
    return ChunkedMessage(parts)


def to_cbor(message: Any) -> Any:
    """A message as the values that `dumps` takes."""
    cls = type(message)
    write = _writers.get(cls)
    if write is None:
        write = _writers[cls] = CborWriter().function(cls._binding.layout)
    try:
        return write(message)
    except (AttributeError, BufferError, TypeError, ValueError):
        return write(decode(cls, encode(message)))  # as in `values.to_json`


def dumps(value: Any) -> bytes:
    """Bytes of values.

    Raises:
        MissingLibrary: cbor2 is not installed.
    """
    try:
        data: bytes = _library().dumps(value)
    except UnicodeEncodeError:  # a text of the robot that was no UTF-8
        data = _library().dumps(_encodable(value))
    return data


def _encodable(value: Any) -> Any:
    """The same with a question mark for what UTF-8 has no bytes for."""
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, dict):
        return {key: _encodable(item) for key, item in value.items()}
    return [_encodable(item) for item in value] if isinstance(value, list) else value


def _library() -> Any:
    try:
        return import_module("cbor2")
    except ImportError as error:
        raise MissingLibrary(
            'compression cbor and cbor-raw need the package cbor2: pip install ".[bridge]"'
        ) from error


class CborWriter(Writer):
    """Generates functions that return dicts."""

    def __init__(self) -> None:
        tag = _library().CBORTag

        def array(number: int, dtype: str, values: Any) -> Any:
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


def _time(value: Any) -> dict[str, int]:
    return {"secs": value.secs, "nsecs": value.nsecs}


def _octets(values: Any) -> bytes:
    return values if type(values) is bytes else _bytes(values, "u1")


def _bytes(values: Any, dtype: str) -> bytes:
    """Of an array as messages have them; TypeError for a list or another width, which the codec converts."""
    if getattr(values, "dtype", None) != dtype:
        raise TypeError(dtype)
    data: bytes = values.tobytes()
    return data
