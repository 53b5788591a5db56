"""What "type" means when a topic is opened: a class, a "package/Type" name, or None for whatever comes.

Source: wiki.ros.org/ROS/Connection Header; the wildcard "*" is what rostopic and rosbag send.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from rosproto.codec import AnyMsg, Message, decoder, define, encode_parts, encoder, message_class
from rosproto.errors import CodecError, DefinitionError, RemoteProtocolError
from rosproto.msg import DefinitionLibrary

ANY = "*"

TypeGiven = type[Message] | str | None
"""A message class, "package/Type", or None: take the publisher's own definition."""


class Libraries(Protocol):
    """Where a type given by name is looked for: `Revisions`."""

    def library_for(self, name: str) -> DefinitionLibrary | None:
        """The library that has it; None for the bundled one."""


class TopicType:
    """One type as the node uses it: names for the wire, class and functions for the bytes.

    Attributes:
        name: "package/Type", or "*".
        md5sum: 32 hexadecimal digits, or "*".
        message_class: The class; `AnyMsg` for the wildcard.
    """

    __slots__ = ("_decode", "_encode", "md5sum", "message_class", "name")

    def __init__(self, message_class: type[Message]) -> None:
        self.message_class = message_class
        self.name: str = message_class._type
        self.md5sum: str = message_class._md5sum
        self._decode: Callable[..., Any] | None = None
        self._encode: Callable[[Any], bytes] | None = None

    @property
    def is_wildcard(self) -> bool:
        """True when any type fits."""
        return self.md5sum == ANY

    @property
    def definition(self) -> str:
        """Full text, as `message_definition` carries it."""
        text: str = self.message_class._full_text
        return text

    @property
    def decode(self) -> Callable[..., Any]:
        """The generated decoder (buffer, start, end) -> message; generated when first asked for."""
        if self._decode is None:
            self._decode = decoder(self.message_class)
        return self._decode

    @property
    def encode(self) -> Callable[[Any], bytes]:
        """The generated encoder message -> bytes."""
        if self._encode is None:
            self._encode = encoder(self.message_class)
        return self._encode

    @property
    def may_be_large(self) -> bool:
        """True when a message may hold arrays that are better sent in parts than copied together."""
        return bool(getattr(self.message_class, "_has_views", False))

    def encode_parts(self, message: Any) -> list[bytes | memoryview]:
        """Encoded in parts; large arrays are the caller's own memory."""
        return encode_parts(message)

    def fits(self, other: TopicType) -> bool:
        """True when both may be used for one topic of one node."""
        return self.is_wildcard or other.is_wildcard or self.md5sum == other.md5sum

    def __repr__(self) -> str:
        return f"<TopicType {self.name} {self.md5sum}>"


WILDCARD = TopicType(AnyMsg)


def resolve_type(given: Any, revisions: Libraries | None = None) -> TopicType:
    """The type a caller meant; a name is looked for in the user's own folders, then among the bundled ones,
    then in what was learned (`Revisions.library_for`).

    Raises:
        DefinitionError: No such type is known.
        TypeError: It is none of the three forms.
    """
    if given is None or given == ANY:
        return WILDCARD
    if isinstance(given, str):
        return TopicType(message_class(given, revisions.library_for(given) if revisions else None))
    if isinstance(given, type) and hasattr(given, "_md5sum") and hasattr(given, "_type"):
        return TopicType(given)
    raise TypeError(
        f'a topic type is a message class, a "package/Type" string or None,'
        f" not {type(given).__name__} {given!r}"
    )


def learn_type(name: str, md5sum: str, definition: str, *, topic: str, peer: str) -> TopicType:
    """The type a publisher described in its connection header.

    A bundled definition with the same md5sum is preferred: its class is the one the user imports.

    Raises:
        RemoteProtocolError: The text is no definition, or its md5sum is not the one the publisher announced.
    """
    try:
        known = TopicType(message_class(name))
        if known.md5sum == md5sum:
            return known
    except DefinitionError:
        pass  # not bundled: the publisher's own text will do
    try:
        learned = TopicType(define(name, definition))
    except (DefinitionError, CodecError, ValueError) as error:
        raise RemoteProtocolError(
            f"{topic}: {peer} describes {name} in a text that cannot be used: {error}"
        ) from error
    if learned.md5sum != md5sum:
        raise RemoteProtocolError(
            f"{topic}: {peer} announces {name} with md5sum {md5sum}, but the definition it sent has"
            f" {learned.md5sum}: its messages could be decoded wrongly, so they are not taken"
        )
    return learned
