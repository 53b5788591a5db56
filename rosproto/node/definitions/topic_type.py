"""`TopicType`: name, md5sum, class, encoder and decoder of a message type.

The wildcard "*" stands for any type, as rostopic and rosbag send it (wiki.ros.org/ROS/Connection Header).
"""

from __future__ import annotations

from collections.abc import Callable

from rosproto.codec import AnyMsg, Message, decoder, encoder
from rosproto.protocol.framing import Decode

ANY = "*"


class TopicType:
    """A message type: name, md5sum, class, encoder and decoder.

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
        self._decode: Decode[Message] | None = None
        self._encode: Callable[[Message], bytes] | None = None

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
    def decode(self) -> Decode[Message]:
        """The decoder (buffer, start, end) -> message; generated on first use."""
        if self._decode is None:
            self._decode = decoder(self.message_class)
        return self._decode

    @property
    def encode(self) -> Callable[[Message], bytes]:
        """The generated encoder message -> bytes."""
        if self._encode is None:
            self._encode = encoder(self.message_class)
        return self._encode

    @property
    def may_be_large(self) -> bool:
        """True if a message may contain large arrays, which are sent in parts without a copy."""
        return bool(getattr(self.message_class, "_has_views", False))

    def fits(self, other: TopicType) -> bool:
        """True when both may be used for one topic of one node."""
        return self.is_wildcard or other.is_wildcard or self.md5sum == other.md5sum

    def __repr__(self) -> str:
        return f"<TopicType {self.name} {self.md5sum}>"


WILDCARD = TopicType(AnyMsg)
