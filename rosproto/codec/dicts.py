"""Convert messages to dicts of plain values and back, for JSON, YAML and the command line.

`fill` accepts the values of `rostopic pub` and `rosservice call`: a dict by field name, a list by position, a
single value for a message of one field, `now` for a time, `auto` for a Header (genpy: fill_message_args).
A whole number for a time is in nanoseconds, as in genpy; one with a point, which genpy refuses, in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeVar

from rosproto.codec.classes import message_class
from rosproto.codec.message import Message
from rosproto.errors import CodecError
from rosproto.json_values import plain
from rosproto.msg.parser import INTEGER_RANGES
from rosproto.sentence import both, say
from rosproto.time import Duration, Time, TVal

M = TypeVar("M", bound=Message)

INTEGERS = frozenset(INTEGER_RANGES)
FLOATS = frozenset(("float32", "float64"))
SECONDS = {"time": (0, (1 << 32) - 1), "duration": INTEGER_RANGES["int32"]}
TIMES: dict[str, type[Time] | type[Duration]] = {"time": Time, "duration": Duration}


class WrongValue(CodecError):
    """A value that a person typed does not fit its field."""

    exit_code = 2  # wrong use


def to_dict(message: object, *, finite: bool = False) -> dict[str, Any]:
    """A message as nested dicts, lists, str, int, float and bool.

    Args:
        message: Any message.
        finite: Replace NaN and infinities, which JSON lacks, by None.

    Returns:
        A dict in the order of the definition; times are `{"secs": int, "nsecs": int}`, arrays lists.
    """
    document: dict[str, Any] = plain(message, finite=finite, names=False)
    return document


def from_dict(cls: type[M], value: object, *, now: Time | None = None) -> M:
    """A new message of a class with these values; other fields keep their defaults.

    Raises:
        WrongValue: A field does not exist or a value does not fit; names it and the existing fields.
    """
    message = cls()
    fill(message, value, now=now)
    return message


def fill(message: Message, value: object, *, now: Time | None = None) -> None:
    """Set the fields of a message from plain values.

    Args:
        message: Changed in place.
        value: Dict by field name, list by position, None for no change, or one value for a message of one
            field.
        now: The time for `now` (a time) and `auto` (a Header); without it they are errors.

    Raises:
        WrongValue: A field does not exist or a value does not fit; names it and the existing fields.
    """
    _fill(message, value, now, "", message._type)


def _fill(message: Any, value: object, now: Time | None, path: str, top: str) -> None:
    slots = message.__slots__
    if value is None:
        return
    if message._type == "std_msgs/Header" and value == "auto":
        message.stamp = _now(now, f"{path}.stamp", top)
        return
    if isinstance(value, dict):
        for name in value:
            if name not in slots:
                raise _wrong(f"has no field {name!r}; it has: {', '.join(slots) or 'none'}", path, top)
        pairs = list(value.items())
    else:
        items = value if isinstance(value, (list, tuple)) else [value]
        if len(items) != len(slots) and not _one_array(message, items):
            raise _wrong(
                f"{len(items)} values given for the {len(slots)} fields of {message._type}: "
                f"{', '.join(slots) or 'none'}",
                path,
                top,
            )
        pairs = [(slots[0], items)] if len(items) != len(slots) else list(zip(slots, items, strict=True))
    types = dict(zip(slots, message._slot_types, strict=True))
    for name, item in pairs:
        inner = f"{path}.{name}" if path else name
        current = getattr(message, name)
        setattr(message, name, _value(types[name], item, now, inner, top, current, type(message)))


def _one_array(message: Message, items: Sequence[object]) -> bool:
    """Whether `items`, such as `[1, 2, 3]`, is the array of a message without other fields."""
    return len(message.__slots__) == 1 and message._slot_types[0].endswith("]") and len(items) != 1


def _value(
    kind: str, value: object, now: Time | None, path: str, top: str, current: object, owner: type[Message]
) -> object:
    if kind.endswith("]"):
        return _array(kind.partition("[")[0], value, now, path, top, owner)
    if kind in TIMES:
        return _time(kind, value, now, path, top)
    if kind == "string":
        return _string(value, path, top)
    if kind == "bool":
        if isinstance(value, int) and value in (0, 1):
            return bool(value)
        raise _wrong(say("{value} is not a bool: write true or false", value=repr(value)), path, top)
    if kind in INTEGERS or kind in FLOATS:
        return _number(kind, value, path, top)
    _fill(current, value, now, path, top)
    return current


def _array(
    base: str, value: object, now: Time | None, path: str, top: str, owner: type[Message]
) -> Sequence[object]:
    if isinstance(value, (bytes, bytearray)):
        return bytes(value)
    items = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(items, (list, tuple)):
        raise _wrong(say("{value} is not a list; expected {type}[]", value=repr(value), type=base), path, top)
    if base in INTEGERS or base in FLOATS:
        return [_number(base, item, f"{path}[{i}]", top) for i, item in enumerate(items)]
    assert owner._binding is not None
    library = owner._binding.library

    def fresh() -> Message | None:
        return message_class(base, library)() if "/" in base else None

    return [_value(base, item, now, f"{path}[{i}]", top, fresh(), owner) for i, item in enumerate(items)]


def _number(kind: str, value: object, path: str, top: str) -> int | float:
    if kind in FLOATS:
        if isinstance(value, (int, float)):
            return float(value)
    elif isinstance(value, int) or (isinstance(value, float) and value.is_integer()):
        low, high = INTEGER_RANGES[kind]
        if low <= value <= high:
            return int(value)
        raise _wrong(f"{value!r} is out of range for {kind}; expected {low} to {high}", path, top)
    raise _wrong(say("{value} is not a valid {type}", value=repr(value), type=kind), path, top)


def _string(value: object, path: str, top: str) -> str:
    if value is None:  # `frame_id:` typed without a value
        return ""
    if isinstance(value, str):
        return value
    # What was typed is not known any more: 007 has become 7.
    hint = ("quote it",) if isinstance(value, (int, float)) else ()
    raise _wrong(both(say("{value} is not a string", value=repr(value)), *hint), path, top)


def _time(kind: str, value: object, now: Time | None, path: str, top: str) -> TVal:
    cls = TIMES[kind]
    if value == "now" and cls is Time:
        return _now(now, path, top)
    if isinstance(value, TVal):
        value = {"secs": value.secs, "nsecs": value.nsecs}
    elif isinstance(value, (list, tuple)) and len(value) == 2:
        value = {"secs": value[0], "nsecs": value[1]}
    elif isinstance(value, float) and math.isfinite(value):
        value = round(value * 1e9)
    if isinstance(value, int) and not isinstance(value, bool):
        value = dict(zip(("secs", "nsecs"), divmod(value, 1_000_000_000), strict=True))
    if not isinstance(value, dict) or not set(value) <= {"secs", "nsecs"}:
        expected = "write {secs: 1, nsecs: 0}, nanoseconds, seconds with a decimal point, or now"
        raise _wrong(f"{value!r} is not a {kind}: {expected}", path, top)
    nsecs = _number("int32", value.get("nsecs", 0), f"{path}.nsecs", top)
    carried, nsecs = divmod(int(nsecs), 1_000_000_000)
    secs = int(_number("int64", value.get("secs", 0), f"{path}.secs", top)) + carried
    low, high = SECONDS[kind]
    if not low <= secs <= high:
        raise _wrong(f"{secs} is out of range for a {kind}; expected {low} to {high}", f"{path}.secs", top)
    return cls(secs, nsecs)


def _now(now: Time | None, path: str, top: str) -> Time:
    if now is None:
        raise _wrong("'now' and 'auto' have no meaning here: there is no clock", path, top)
    return Time(now.secs, now.nsecs)


def _wrong(message: str, path: str, top: str) -> WrongValue:
    return WrongValue(message, type_name=top, field_path=path)
