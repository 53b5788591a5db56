"""Converts messages to rosbridge's JSON, and values from clients to messages.

Source: `rosbridge_library.internal.message_conversion` (rosbridge_suite, branch ros1). Valid values give the
same result. A wrong value that the original accepts silently (text that is not base64, a number for a time,
an array of another length) is an error here that names the field.
"""

from __future__ import annotations

import struct
from base64 import b64decode
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar
from weakref import WeakKeyDictionary

from rosproto.codec import decode, encode
from rosproto.codec.layout import DTYPES, RANGES_BY_CODE, FieldLayout, Layout
from rosproto.codec.message import Message
from rosproto.errors import CodecError
from rosproto.gateway.json_writer import JsonWriter, in_parts
from rosproto.json_fields import shown
from rosproto.time import Time

_WORDS = {"": "a text", "?": "true or false", "f": "a number", "d": "a number"}
_SINGLE = struct.Struct("<f")
_HEADERS = frozenset({"std_msgs/Header", "roslib/Header"})

M = TypeVar("M", bound=Message)
T = TypeVar("T")

_writers: WeakKeyDictionary[type[Message], Callable[[Message], str]] = WeakKeyDictionary()


def to_json(message: Message) -> str:
    """A message as rosbridge's JSON text.

    Raises:
        CodecError: A field holds what does not belong there.
    """
    return _written(message, lambda write, values: write(values))


def to_json_parts(message: Message) -> list[str]:
    """As `to_json`, in parts for a long message: no long array is in one piece.

    Raises:
        CodecError: A field holds what does not belong there.
    """
    return _written(message, in_parts)


def _written(message: Message, how: Callable[[Callable[[Message], str], Message], T]) -> T:
    cls = type(message)
    write = _writers.get(cls)
    if write is None:
        assert cls._binding is not None
        write = _writers[cls] = JsonWriter().function(cls._binding.layout)
    try:
        return how(write, message)
    except (AttributeError, BufferError, TypeError, ValueError):
        # Values that encode but never come from decoding, such as an int for a float.
        return how(write, decode(cls, encode(message)))


def from_values(
    cls: type[M], value: object, *, now: Time | None = None, seconds: Literal["secs", "sec"] = "secs"
) -> M:
    """Make a message from a client's values; missing fields keep their defaults.

    Args:
        cls: Its class.
        value: Decoded JSON, an object by field.
        now: The time for "now", and the stamp of each given Header without one.
        seconds: Name of the seconds of a time: "secs" (with "nsecs"), or for viewers "sec" (with "nsec").

    Raises:
        CodecError: A field does not exist, or a value does not fit; names the field.
    """
    message = cls()
    reader = _Reader(cls, now, seconds)
    reader.message(reader.binding.layout, message, value, "")
    return message


def from_arguments(cls: type[M], args: object, *, now: Time | None = None) -> M:
    """Make a service request or goal from `args`: an object by field, an array by position, or None.

    Raises:
        CodecError: A value does not fit its field, or there are more arguments than fields.
    """
    if isinstance(args, list):
        names = cls.__slots__
        if len(args) > len(names):
            raise CodecError(
                f"{len(args)} arguments given, but it has the fields: {', '.join(names) or 'none'}",
                type_name=cls._type,
            )
        args = dict(zip(names, args, strict=False))
    return from_values(cls, {} if args is None else args, now=now)


class _Reader:
    """Reads one message."""

    def __init__(self, cls: type[Message], now: Time | None, seconds: str) -> None:
        assert cls._binding is not None, f"{cls} is not a type of messages"
        self.binding = cls._binding
        self.top = cls._type
        self.now = now
        self.parts = (seconds, f"n{seconds}")
        self.fields: dict[str, dict[str, FieldLayout]] = {}

    def error(self, text: str, path: str) -> CodecError:
        return CodecError(text, type_name=self.top, field_path=path)

    def wrong(self, expected: str, value: object, path: str) -> CodecError:
        return self.error(f"{shown(value)} given; expected {expected}", path)

    def message(self, layout: Layout, message: Any, value: object, path: str) -> None:
        """Fill `message`."""
        if type(value) is not dict:
            raise self.wrong(f"an object with the fields of {layout.spec.name}", value, path)
        if layout.spec.name in _HEADERS and self.now is not None:
            message.stamp = self.binding.value_style.time.from_wire(self.now.secs, self.now.nsecs)
        fields = self.fields.get(layout.spec.name)
        if fields is None:
            fields = self.fields[layout.spec.name] = {field.name: field for field in layout.fields}
        for name, item in value.items():
            field = fields.get(name)
            if field is None:
                text = (
                    f"{layout.spec.name} has no field {name[:100]!r}; it has: {', '.join(fields) or 'none'}"
                )
                raise self.error(text, path)
            inner = f"{path}.{name}" if path else name
            if field.is_array:
                setattr(message, field.attr, self.array(field, item, inner))
            elif field.layout is not None:
                self.message(field.layout, getattr(message, field.attr), item, inner)
            else:
                setattr(message, field.attr, self.one(field, item, inner, getattr(message, field.attr)))

    def one(self, field: FieldLayout, value: Any, path: str, present: object = None) -> object:
        """A number, text or time."""
        if field.kind == "time":
            return self.time(field, value, path, present)
        kind = type(value)
        if field.kind == "string":
            if kind is str:
                return self.text(value, path)
        elif field.code == "?":
            if kind is bool:
                return value
        elif field.code in "fd":
            if kind is float or (kind is int and value.bit_length() <= 1023):
                return self.real(field, float(value), path)
        elif kind is int:
            low, high = RANGES_BY_CODE[field.code]
            if low <= value <= high:
                return value
            raise self.wrong(f"{low} to {high}", value, path)
        raise self.wrong(_WORDS.get(field.code, "a whole number"), value, path)

    def text(self, value: str, path: str) -> str:
        if not value.isascii():
            try:
                value.encode("utf-8")
            except UnicodeEncodeError as error:
                half = f"half a character (surrogate U+{ord(value[error.start]):04X})"
                raise self.error(f"{half} at {error.start}; expected a text of whole ones", path) from None
        return value

    def real(self, field: FieldLayout, value: float, path: str) -> float:
        if field.code == "f":
            try:
                _SINGLE.pack(value)
            except OverflowError:
                raise self.wrong("a number within float32", value, path) from None
        return value

    def time(self, field: FieldLayout, value: Any, path: str, present: object) -> object:
        value_style = self.binding.value_style
        if value == "now" and field.base == "time":
            if self.now is None:
                raise self.error("'now' means nothing here: there is no clock", path)
            return value_style.time.from_wire(self.now.secs, self.now.nsecs)
        if type(value) is not dict or not value.keys() <= set(self.parts):
            names = ", ".join(f'"{name}"' for name in self.parts)
            raise self.wrong(f"an object {{{names}}}" + ', or "now"' * (field.base == "time"), value, path)
        if not value and present is not None:
            return present
        low, high = RANGES_BY_CODE[field.code[0]]
        parts = []
        for name in self.parts:
            part = value.get(name, 0)
            if type(part) is not int or not low <= part <= high:
                raise self.wrong(f"a whole number from {low} to {high}", part, f"{path}.{name}")
            parts.append(part)
        return (value_style.time if field.base == "time" else value_style.duration).from_wire(*parts)

    def array(self, field: FieldLayout, value: object, path: str) -> object:
        if field.code == "B" and type(value) is str:
            items: Sequence[object] = self.octets(value, path)
        elif type(value) is not list:
            raise self.wrong("an array" + ", or its bytes as base64" * (field.code == "B"), value, path)
        else:
            items = value
        if field.length is not None and len(items) != field.length:
            raise self.error(f"{len(items)} elements given; expected {field.length}", path)
        if isinstance(items, bytes):
            return items
        if field.layout is not None:
            return [self.element(field.layout, item, f"{path}[{i}]") for i, item in enumerate(items)]
        if field.kind == "number" and field.code != "?":
            return self.numbers(field, items, path)
        return [self.one(field, item, f"{path}[{i}]") for i, item in enumerate(items)]

    def element(self, layout: Layout, value: object, path: str) -> object:
        message = self.binding.class_for(layout.spec.name)()
        self.message(layout, message, value, path)
        return message

    def octets(self, value: str, path: str) -> bytes:
        try:
            return b64decode("".join(value.split()), validate=True)
        except ValueError as error:
            raise self.error(f"no base64: {error}", path) from None

    def numbers(self, field: FieldLayout, value: Sequence[object], path: str) -> object:
        """An array of numbers, checked at the speed of `struct`."""
        kinds = set(map(type, value))
        if kinds <= ({int, float} if field.code in "fd" else {int}):
            try:
                packed = struct.Struct(f"<{len(value)}{field.code}").pack(*value)
            except (struct.error, OverflowError):
                pass
            else:
                if field.code == "B":
                    return packed
                if not self.binding.value_style.views:
                    return value
                import numpy as np

                return np.frombuffer(packed, DTYPES[field.base])
        # Find the wrong element.
        return [self.one(field, item, f"{path}[{i}]") for i, item in enumerate(value)]


def definition_name(name: str) -> str:
    """The name of a message or service type in ROS 1's form, also from ROS 2's `std_msgs/msg/String`.

    Extra slashes are removed, as in rosbridge. Anything else is returned unchanged, and looking it up then
    reports the error.
    """
    parts = [part for part in name.split("/") if part]
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        del parts[1]
    return "/".join(parts) if len(parts) == 2 else name
