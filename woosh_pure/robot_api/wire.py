"""Messages of the Robot API as dicts of checked values. Pure.

The interface is the JSON mapping of protobuf 3. `load` makes values of a JSON body, `dump` a JSON body of
values. Values are dicts with the wire's names in lowerCamelCase (`mapId`), nested:

- Each field is there, with its default where the body has none: 0, 0.0, False, "", b"", [].
- Exceptions are sub-messages and members of a oneof (`robotId`, `stepControl`), which are absent if not set.
- Enums are ints, also numbers that no name is known for. 64 bit numbers are ints, bytes are bytes.
- Floats may be NaN or infinite: ranges of a scan are. The caller refuses them where they mean nothing.

A frame is one JSON object of the WebSocket; over HTTP the body of a request is sent alone.
"""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from importlib import resources
from typing import Any, Literal, NamedTuple

from rosproto.errors import CodecError
from rosproto.json_fields import Expected, shown
from rosproto.text import short

PORT = 5480
MAX_VALUES = 1_000_000
"""Elements of all lists of one body."""
SUBSCRIPTION = "woosh.Subscription"
_NUMBER = re.compile(r"-?[0-9]{1,40}(\.[0-9]{1,40})?([eE][-+]?[0-9]{1,3})?")
_NOT_FINITE = ("NaN", "Infinity", "-Infinity")
_MAX_FLOAT = 3.4028235677973362e38  # rounds to the largest number of float32

Values = dict[str, Any]


class RequestType(NamedTuple):
    """A request of the interface.

    Attributes:
        kind: Whether it reads, changes something, or may move the robot.
        answer: Type of the answer.
        empty: The answer's body is empty.
    """

    kind: Literal["read", "change", "move"]
    answer: str
    empty: bool


class Field(NamedTuple):
    """A field of a message.

    Attributes:
        name: In snake_case.
        key: In lowerCamelCase, as it is written.
        number: Of protobuf.
        type: A scalar type of protobuf, or the name of an enum or message.
        repeated: Whether it is a list.
        oneof: The name of its oneof; "" if it is in none.
    """

    name: str
    key: str
    number: int
    type: str
    repeated: bool
    oneof: str


@lru_cache(maxsize=1)
def _data() -> dict[str, Any]:
    text = resources.files("woosh_pure").joinpath("data/robot_api.json").read_text(encoding="utf-8")
    data: dict[str, Any] = json.loads(text)
    return data


@lru_cache(maxsize=1)
def requests() -> Mapping[str, RequestType]:
    """The requests that a robot answers, by type."""
    found = {}
    for type_name, words in _data()["requests"].items():
        kind, _, rest = words.partition(" ")
        found[type_name] = RequestType(kind, type_name if rest in ("", "empty") else rest, rest == "empty")
    return found


@lru_cache(maxsize=1)
def topics() -> frozenset[str]:
    """The types that a robot pushes to clients which subscribe to them."""
    return frozenset(_data()["topics"])


def messages() -> tuple[str, ...]:
    """The names of all messages."""
    return tuple(_data()["messages"])


def enum(type_name: str) -> Mapping[str, int]:
    """The numbers of an enum or bit mask by name.

    Raises:
        KeyError: There is no such enum.
    """
    numbers: dict[str, int] = _data()["enums"][type_name]
    return numbers


@cache
def fields(type_name: str) -> tuple[Field, ...]:
    """The fields of a message.

    Raises:
        CodecError: There is no such message.
    """
    described = _data()["messages"].get(type_name)
    if described is None:
        raise CodecError(f"{short(type_name)!r} is not a message of the Robot API")
    found = []
    for name, words in described.items():
        number, kind, *oneof = words.split()
        first, *more = name.split("_")
        key = first + "".join(part[:1].upper() + part[1:] for part in more)
        found.append(Field(name, key, int(number), kind.removesuffix("[]"), kind[-1] == "]", "".join(oneof)))
    return tuple(found)


# -- bodies --------------------------------------------------------------------------------------------------


def load(type_name: str, body: object, *, strict: bool = False) -> Values:
    """The values of a message from its JSON body; None, a body that was left out, is an empty one.

    Args:
        type_name: The message, "woosh.robot.Twist".
        body: Decoded JSON. Fields may be named in both spellings, and numbers be texts.
        strict: Refuse unknown fields, as for what a user typed. By default they are left out, because newer
            robots send more.

    Raises:
        CodecError: There is no such message, or a value does not fit; names the field.
    """
    return _Loader(type_name, strict).message(type_name, {} if body is None else body, "")


def dump(type_name: str, values: Mapping[str, Any], zeros: bool = True) -> Values:
    """The JSON body of values as `load` returns them; absent fields have their defaults.

    Args:
        type_name: The message.
        values: By lowerCamelCase name. Lists may be arrays of numpy; bytes may be base64 already.
        zeros: Write defaults of fields, as robots do; without, only what differs from them, as clients do.

    Raises:
        CodecError: There is no such message or field, or a value does not fit.
    """
    return _written(type_name, _Loader(type_name, True).message(type_name, values, ""), zeros)


def _written(type_name: str, values: Values, zeros: bool) -> Values:
    body: Values = {}
    for field in fields(type_name):
        value = values.get(field.key)
        default, _, write = _scalar(field.type)
        if value is None or (not zeros and not field.oneof and value == ([] if field.repeated else default)):
            continue
        if default is None:
            body[field.key] = (
                [_written(field.type, one, zeros) for one in value]
                if field.repeated
                else _written(field.type, value, zeros)
            )
        elif write is None:
            body[field.key] = value
        else:
            body[field.key] = [write(one) for one in value] if field.repeated else write(value)
    return body


class _Loader:
    """Reads one body; messages do not contain themselves, so its depth is that of the types."""

    def __init__(self, type_name: str, strict: bool) -> None:
        self.top, self.strict, self.left = type_name, strict, MAX_VALUES

    def error(self, text: str, path: str) -> CodecError:
        return CodecError(text, type_name=self.top, field_path=path)

    def message(self, type_name: str, body: object, path: str) -> Values:
        known = fields(type_name)
        if not isinstance(body, Mapping):
            raise self.error(f"{shown(body)} given; expected an object with the fields of {type_name}", path)
        if self.strict:
            names = {name for field in known for name in (field.name, field.key)}
            for name in body:
                if name not in names:
                    listed = ", ".join(field.key for field in known) or "none"
                    text = f"{type_name} has no field {short(str(name))!r}; it has: {listed}"
                    raise self.error(text, path)
        found: Values = {}
        chosen: dict[str, str] = {}
        for field in known:
            value = body.get(field.key)
            if value is None:
                value = body.get(field.name)
            inner = f"{path}.{field.key}" if path else field.key
            if field.repeated:
                found[field.key] = self.array(field.type, [] if value is None else value, inner)
                continue
            if value is None:
                default = _scalar(field.type)[0]
                if not field.oneof and default is not None:
                    found[field.key] = default
                continue
            if field.oneof and chosen.setdefault(field.oneof, field.key) != field.key:
                raise self.error(f"{chosen[field.oneof]} is there, too; expected only one of them", inner)
            found[field.key] = self.one(field.type, value, inner)
        return found

    def array(self, type_name: str, value: Any, path: str) -> list[Any]:
        value = value.tolist() if hasattr(value, "tolist") else value
        if not isinstance(value, (list, tuple)):
            raise self.error(f"{shown(value)} given; expected an array", path)
        self.left -= len(value)
        if self.left < 0:
            raise self.error(f"the lists have more than {MAX_VALUES} elements", path)
        return [self.one(type_name, one, f"{path}[{at}]") for at, one in enumerate(value)]

    def one(self, type_name: str, value: object, path: str) -> Any:
        default, read, _ = _scalar(type_name)
        if default is None:
            return self.message(type_name, value, path)
        try:
            return read(value)
        except Expected as expected:
            raise self.error(f"{shown(value)} given; expected {expected}", path) from None


# -- scalars -------------------------------------------------------------------------------------------------


def _whole(low: int, high: int) -> Callable[[Any], int]:
    def read(value: Any) -> int:
        if isinstance(value, str) and _NUMBER.fullmatch(value):
            value = int(value) if value.removeprefix("-").isdecimal() else float(value)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, int) and not isinstance(value, bool) and low <= value <= high:
            return int(value)
        raise Expected(f"a whole number from {low} to {high}")

    return read


def _real(value: Any) -> float:
    if isinstance(value, str) and (value in _NOT_FINITE or _NUMBER.fullmatch(value)):
        value = float(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if -_MAX_FLOAT <= value <= _MAX_FLOAT or (isinstance(value, float) and not math.isfinite(value)):
            return float(value)
        raise Expected("a number within float32")
    raise Expected("a number")


def _flag(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    raise Expected("true or false")


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise Expected("a text")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise Expected("a text of whole characters") from None
    return value


def _octets(value: Any) -> bytes:
    if isinstance(value, bytes):
        return value
    if isinstance(value, str):
        text = value.replace("-", "+").replace("_", "/").rstrip("=")
        try:
            return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
        except ValueError:
            pass
    raise Expected("bytes as base64")


def _enum(type_name: str) -> Callable[[Any], int]:
    names, number = enum(type_name), _whole(-(2**31), 2**31 - 1)

    def read(value: Any) -> int:
        known = names.get(value) if isinstance(value, str) else None
        if known is not None:
            return known
        try:
            return number(value)
        except Expected:
            raise Expected(f"a number or a name of {type_name}") from None

    return read


def _written_float(value: float) -> float | str:
    return value if math.isfinite(value) else json.dumps(value)  # "NaN", "Infinity", "-Infinity"


def _written_bytes(value: bytes) -> str:
    return base64.b64encode(value).decode("ascii")


Scalar = tuple[Any, Callable[[Any], Any], Callable[[Any], Any] | None]
_NO_SCALAR: Scalar = None, _flag, None
_SCALARS: dict[str, Scalar] = {
    "bool": (False, _flag, None),
    "bytes": (b"", _octets, _written_bytes),
    "float": (0.0, _real, _written_float),
    "int32": (0, _whole(-(2**31), 2**31 - 1), None),
    "uint32": (0, _whole(0, 2**32 - 1), None),
    "fixed32": (0, _whole(0, 2**32 - 1), None),
    "int64": (0, _whole(-(2**63), 2**63 - 1), str),
    "uint64": (0, _whole(0, 2**64 - 1), str),
    "string": ("", _text, None),
}


@cache
def _scalar(type_name: str) -> Scalar:
    """Default, reader and writer of a type that is not a message; the default of a message is None."""
    if type_name in _data()["enums"]:
        return 0, _enum(type_name), None
    return _SCALARS.get(type_name, _NO_SCALAR)


# -- frames --------------------------------------------------------------------------------------------------


def request(type_name: str, body: Mapping[str, Any] | None = None, sn: int | None = None) -> Values:
    """The frame of a request. Fields at their defaults are left out, so a zero velocity is `{}`.

    Args:
        type_name: The request.
        body: As for `load`; also values that `load` returned.
        sn: Number that the answer repeats.

    Raises:
        CodecError: There is no such message or field, or a value does not fit.
    """
    frame: Values = {"type": type_name, "body": dump(type_name, body or {}, zeros=False)}
    return frame if sn is None else {**frame, "sn": sn}


def answer(
    type_name: str,
    values: Mapping[str, Any] | None = None,
    *,
    ok: bool = True,
    msg: str = "",
    sn: int | None = None,
) -> Values:
    """The frame of an answer, over HTTP the whole answer.

    Args:
        type_name: Type of the answer; of an unknown request as it was asked.
        values: None for an empty body, as for a refusal.
        ok: Whether the request was accepted.
        msg: Why not.
        sn: Number of the request; None if it had none.
    """
    body = {} if values is None else dump(type_name, values)
    frame: Values = {"type": type_name, "body": body, "ok": ok, "msg": msg}
    return frame if sn is None else {**frame, "sn": sn}


def push(type_name: str, values: Mapping[str, Any]) -> Values:
    """The frame of a push."""
    return {"type": type_name, "body": dump(type_name, values)}


def is_answer(frame: Mapping[str, Any]) -> bool:
    """Whether a frame of a robot answers a request; other frames are pushes.

    The number is not required: a request without one has an answer without one.
    """
    return isinstance(frame.get("ok"), bool) and isinstance(frame.get("msg"), str)


def path_of(type_name: str) -> str:
    """The path of a request over HTTP: "/woosh/robot/Twist"."""
    return "/" + type_name.replace(".", "/")


def type_of(path: str) -> str | None:
    """The request that a path of HTTP names; None if there is no such request."""
    type_name = path.removeprefix("/").replace("/", ".")
    return type_name if path_of(type_name) == path and type_name in requests() else None
