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
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any, Literal, NamedTuple

from rosproto import json_fields
from rosproto.errors import CodecError
from rosproto.json_fields import Check, Expected, shown, whole
from rosproto.text import short

PORT = 5480
MAX_VALUES = 1_000_000
"""Elements of all lists of one body."""
SUBSCRIPTION = "woosh.Subscription"
_NUMBER = re.compile(r"-?[0-9]{1,40}(\.[0-9]{1,40})?([eE][-+]?[0-9]{1,3})?|NaN|-?Infinity")
_MAX_FLOAT = 3.4028235677973362e38  # rounds to the largest number of float32

Values = dict[str, Any]


class RequestType(NamedTuple):
    """A request: whether it reads, changes something or may move the robot; the type of its answer, and
    whether that is empty."""

    kind: Literal["read", "change", "move"]
    answer: str
    empty: bool


class Field(NamedTuple):
    """A field of a message: its name in snake_case, as `key` in lowerCamelCase; its number and type (a scalar
    of protobuf, an enum or a message), whether it is a list, and its oneof, "" if it is in none."""

    name: str
    key: str
    number: int
    type: str
    repeated: bool
    oneof: str


@cache
def _data() -> Any:
    return json.loads(resources.files("woosh_pure").joinpath("data/robot_api.json").read_text("utf-8"))


@cache
def requests() -> Mapping[str, RequestType]:
    """The requests that a robot answers, by type."""
    found = {}
    for type_name, words in _data()["requests"].items():
        kind, _, rest = words.partition(" ")
        found[type_name] = RequestType(kind, type_name if rest in ("", "empty") else rest, rest == "empty")
    return found


@cache
def topics() -> frozenset[str]:
    """The types that a robot pushes to clients which subscribe to them."""
    return frozenset(_data()["topics"])


def messages() -> tuple[str, ...]:
    """The names of all messages."""
    return tuple(_data()["messages"])


def enum(type_name: str) -> Mapping[str, int]:
    """The numbers of an enum or bit mask by name; KeyError if there is none."""
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


def load(type_name: str, body: object) -> Values:
    """The values of a message from its JSON body; None, a body that was left out, is an empty one.

    Fields may be named in both spellings, and numbers be texts. Unknown ones are left out, because newer
    robots send more.

    Raises:
        CodecError: There is no such message, or a value does not fit; names the field.
    """
    return _Loader(type_name, strict=False).message(type_name, {} if body is None else body, "")


def dump(type_name: str, values: Mapping[str, Any], zeros: bool = True) -> Values:
    """The JSON body of values as `load` returns them; absent fields have their defaults.

    Args:
        values: By lowerCamelCase name. Lists may be arrays of numpy; bytes may be base64 already.
        zeros: Write defaults, as robots do. Without, only what differs from them, as clients do: a zero
            velocity is `{}`.

    Raises:
        CodecError: There is no such message or field, or a value does not fit.
    """
    body: Values = _json(type_name, _Loader(type_name, strict=True).message(type_name, values, ""), zeros)
    return body


def _json(type_name: str, value: Any, zeros: bool) -> Any:
    if isinstance(value, list):
        return [_json(type_name, one, zeros) for one in value]
    if isinstance(value, dict):
        return {
            key: _json(kind, value[key], zeros)
            for _, key, _, kind, _, oneof in fields(type_name)
            if key in value and (zeros or oneof or value[key] not in ([], _scalar(kind)[0]))
        }
    if isinstance(value, bytes):
        return base64.b64encode(value).decode("ascii")
    if isinstance(value, float) and not math.isfinite(value):
        return json.dumps(value)  # "NaN", "Infinity", "-Infinity"
    return str(value) if type_name in ("int64", "uint64") else value


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
        unknown = set(body).difference(*((field.name, field.key) for field in known)) if self.strict else ()
        if unknown:
            names = ", ".join(field.key for field in known) or "none"
            raise self.error(f"{type_name} has no field {short(str(min(unknown)))!r}; it has: {names}", path)
        found: Values = {}
        chosen: dict[str, str] = {}
        for field in known:
            value = body.get(field.key)
            value = body.get(field.name) if value is None else value
            inner = f"{path}.{field.key}" if path else field.key
            if field.repeated:
                found[field.key] = self.array(field.type, [] if value is None else value, inner)
            elif value is not None:
                if field.oneof and chosen.setdefault(field.oneof, field.key) != field.key:
                    raise self.error(f"{chosen[field.oneof]} is there, too; expected only one of them", inner)
                found[field.key] = self.one(field.type, value, inner)
            elif not field.oneof and (default := _scalar(field.type)[0]) is not None:
                found[field.key] = default
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
        default, read = _scalar(type_name)
        if default is None:
            return self.message(type_name, value, path)
        if isinstance(value, str) and type_name not in _TEXTS and _NUMBER.fullmatch(value):
            value = int(value) if value.removeprefix("-").isdecimal() else float(value)
        try:
            return read(value, 0)
        except Expected as expected:
            raise self.error(f"{shown(value)} given; expected {expected}", path) from None


# -- scalars -------------------------------------------------------------------------------------------------


def _real(value: Any, longest: int) -> float:
    if type(value) is float and not math.isfinite(value):
        return value
    return json_fields.number(-_MAX_FLOAT, _MAX_FLOAT, "a number within float32")(value, longest)


def _text(value: Any, longest: int) -> str:
    if not isinstance(value, str):
        raise Expected("a text")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise Expected("a text of whole characters") from None
    return value


def _octets(value: Any, longest: int) -> bytes:
    if isinstance(value, bytes):
        return value
    try:
        text = _text(value, longest).replace("-", "+").replace("_", "/").rstrip("=")
        return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
    except ValueError:
        raise Expected("bytes as base64") from None


Scalar = tuple[Any, Check[Any]]
_TEXTS: dict[str, Scalar] = {"bytes": (b"", _octets), "string": ("", _text)}
_SCALARS: dict[str, Scalar] = {
    **_TEXTS,
    "bool": (False, json_fields.flag),
    "float": (0.0, _real),
    "int32": (0, whole(-(2**31), 2**31 - 1)),
    "uint32": (0, whole(0, 2**32 - 1)),
    "fixed32": (0, whole(0, 2**32 - 1)),
    "int64": (0, whole(-(2**63), 2**63 - 1)),
    "uint64": (0, whole(0, 2**64 - 1)),
}


@cache
def _scalar(type_name: str) -> Scalar:
    """Default and reader of a scalar or enum; the default of a message is None."""
    names = _data()["enums"].get(type_name)
    if names is None:
        return _SCALARS.get(type_name, (None, _real))
    check = whole(-(2**31), 2**31 - 1, f"a number or a name of {type_name}")
    return 0, lambda value, _: check(names.get(value, value) if isinstance(value, str) else value, 0)


# -- frames --------------------------------------------------------------------------------------------------


def answer(
    type_name: str,
    values: Mapping[str, Any] | None = None,
    *,
    ok: bool = True,
    msg: str = "",
    sn: int | None = None,
) -> Values:
    """The frame of an answer, over HTTP the whole answer. Without `values`, as for a refusal, its body is
    empty; an unknown request has the type as it was asked."""
    body = {} if values is None else dump(type_name, values)
    frame: Values = {"type": type_name, "body": body, "ok": ok, "msg": msg}
    return frame if sn is None else {**frame, "sn": sn}


def push(type_name: str, values: Mapping[str, Any]) -> Values:
    """The frame of a push, which has neither number nor `ok`."""
    return {"type": type_name, "body": dump(type_name, values)}


def path_of(type_name: str) -> str:
    """The path of a request over HTTP: "/woosh/robot/Twist"."""
    return "/" + type_name.replace(".", "/")


def type_of(path: str) -> str | None:
    """The request that a path of HTTP names; None if there is no such request."""
    type_name = path.removeprefix("/").replace("/", ".")
    return type_name if path_of(type_name) == path and type_name in requests() else None
