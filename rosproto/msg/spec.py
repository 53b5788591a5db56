"""Parsed definitions, made by the parser, and the md5sum that peers compare before they exchange messages.

Source: wiki.ros.org/msg, wiki.ros.org/srv, wiki.ros.org/actionlib; genmsg decides where they are silent. The
md5sum: wiki.ros.org/ROS/Technical%20Overview (section "msg MD5 sums"); gentools.py in genmsg.

Named tuples, not dataclasses: six frozen dataclasses and the modules they import took a third of the import
    time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from hashlib import md5
from typing import NamedTuple

BUILTIN_TYPES = frozenset(
    "bool int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 "
    "string time duration char byte".split()
)


class FieldType(NamedTuple):
    """Type of one field.

    Attributes:
        base: Builtin name as written ("float64", "char") or full message name ("geometry_msgs/Point").
        is_array: True for `T[]` and `T[N]`.
        array_length: N of `T[N]`; None for a single value or `T[]`.
        length_text: N as written if it differs from the plain number, as in `T[007]`: the md5sum of a builtin
            array includes it.
    """

    base: str
    is_array: bool = False
    array_length: int | None = None
    length_text: str | None = None

    @property
    def is_builtin(self) -> bool:
        """True when `base` is not a message."""
        return self.base in BUILTIN_TYPES

    def __str__(self) -> str:
        """The genpy form: "float64", "float64[9]", "geometry_msgs/Point[]"."""
        if not self.is_array:
            return self.base
        return f"{self.base}[{self.length_text or ('' if self.array_length is None else self.array_length)}]"


class Field(NamedTuple):
    """One field: its name and type."""

    name: str
    type: FieldType


class Constant(NamedTuple):
    """One constant.

    Attributes:
        type: Builtin type as written.
        name: Its name.
        value: Python value (int, float, bool or str).
        text: The literal as written in the definition; part of the md5 text.
    """

    type: str
    name: str
    value: int | float | bool | str
    text: str


class MessageSpec(NamedTuple):
    """A message definition.

    Attributes:
        name: "package/Type".
        fields: In order of definition.
        constants: In order of definition.
        text: The definition as written, the source of `_full_text`.
    """

    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...]
    text: str

    @property
    def package(self) -> str:
        return self.name.partition("/")[0]

    @property
    def has_header(self) -> bool:
        """True when the *first* field is `Header header`: publishers set seq only then (genmsg)."""
        return bool(self.fields) and self.fields[0] == Field("header", FieldType("std_msgs/Header"))


class ServiceSpec(NamedTuple):
    """A service definition: request "package/TypeRequest" and response "package/TypeResponse"."""

    name: str
    request: MessageSpec
    response: MessageSpec
    text: str


class ActionSpec(NamedTuple):
    """An action definition.

    Attributes:
        name: "package/Type".
        goal, result, feedback: "package/TypeGoal" and so on, the three written parts.
        messages: The seven messages that actionlib derives, by full name (TypeGoal, TypeResult,
            TypeFeedback, TypeActionGoal, TypeActionResult, TypeActionFeedback, TypeAction).
    """

    name: str
    goal: MessageSpec
    result: MessageSpec
    feedback: MessageSpec
    messages: dict[str, MessageSpec]
    text: str


def md5_text(spec: MessageSpec, md5sum_of: Callable[[str], str]) -> str:
    """The text that is hashed: constants first, then fields, without comments.

    A message type is replaced by its md5sum, **without** the array suffix: `U u`, `U[] u` and `U[3] u` hash
    alike. Builtin arrays keep theirs, aliases keep their name (`byte b` is not `int8 b`), and constants keep
    their literal as written (`True` is not `1`).

    Args:
        spec: The message.
        md5sum_of: Returns the md5sum of a message type by full name.
    """
    lines = [f"{constant.type} {constant.name}={constant.text}" for constant in spec.constants]
    for field in spec.fields:
        kind = str(field.type) if field.type.is_builtin else md5sum_of(field.type.base)
        lines.append(f"{kind} {field.name}")
    return "\n".join(lines)


def unfolded(spec: MessageSpec, message_of: Callable[[str], MessageSpec], indent: str = "") -> Iterator[str]:
    """Yield the lines of a message's constants and fields, with the fields of used messages indented.

    Args:
        spec: The message.
        message_of: Returns a used message by full name.
        indent: In front of each line.
    """
    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.value}"
    for field in spec.fields:
        yield f"{indent}{field.type} {field.name}"
        if not field.type.is_builtin:
            yield from unfolded(message_of(field.type.base), message_of, indent + "  ")


def md5sum_of_texts(*texts: str) -> str:
    """The md5sum of one text, or of a service's two with nothing between them."""
    digest = md5(usedforsecurity=False)  # an identity, not for security: works if FIPS forbids md5
    for text in texts:
        digest.update(text.encode("utf-8", "surrogateescape"))
    result: str = digest.hexdigest()
    return result
