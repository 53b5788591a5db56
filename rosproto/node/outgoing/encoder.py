"""From what a program publishes to the frame that goes out: a message, or its encoded bytes."""

from __future__ import annotations

import itertools
from typing import Any

from rosproto.codec import AnyMsg
from rosproto.errors import CodecError
from rosproto.node.outgoing.frames import LARGE, LargeFrame, small_frame
from rosproto.node.outgoing.outgoing_link import Frame
from rosproto.node.revisions.topic_types import TopicType

RAW = (bytes, bytearray, memoryview, AnyMsg)
"""What is published as it is, without being decoded: a relay."""


class FrameEncoder:
    """Encodes the messages of one topic; header.seq is counted per topic and written into the bytes only."""

    def __init__(self, topic: str, type_: TopicType) -> None:
        self._topic = topic
        self._type = type_
        self._seq = itertools.count(1)
        self._has_header = bool(type_.message_class._has_header)

    @property
    def is_plain(self) -> bool:
        """Neither header nor arrays, as most small messages: then encoding is one call."""
        return not self._has_header and not self._type.may_be_large and not self._type.is_wildcard

    def frame(self, message: Any) -> Frame:
        """The frame of a message, or of its encoded bytes.

        Raises:
            CodecError: A value does not fit its field, or the message is of another type.
        """
        type_ = self._type
        if type_.is_wildcard or type(message) is not type_.message_class:
            if isinstance(message, (bytes, bytearray, memoryview)):
                return _raw_frame(message)  # a relay: nothing is rewritten, header.seq neither (pitfall 59)
            if isinstance(message, AnyMsg):
                return _raw_frame(message._buff)
            self.check_class(message)
        seq = next(self._seq) & 0xFFFFFFFF if self._has_header else None
        if not type_.may_be_large:
            return small_frame(type_.encode(message), seq)
        parts = type_.encode_parts(message)
        if len(parts) == 1 and len(parts[0]) < LARGE:
            return small_frame(bytes(parts[0]), seq)
        frame = LargeFrame(parts, seq)
        return frame if frame.size >= LARGE else frame.owned()

    def check_class(self, message: Any) -> None:
        """Another class of the same type is as good (another flavour, another copy of the definition).

        Raises:
            CodecError: It is of another type.
        """
        type_ = self._type
        if type(message) is type_.message_class or isinstance(message, RAW):
            return
        md5sum = getattr(type(message), "_md5sum", None)
        if md5sum != type_.md5sum:
            given = getattr(type(message), "_type", None) or type(message).__name__
            raise CodecError(
                f"{self._topic} is published as {type_.name} (md5sum {type_.md5sum}), not as {given}"
                + (f" (md5sum {md5sum})" if md5sum else "; give a message, its fields, or encoded bytes")
            )


def _raw_frame(data: bytes | bytearray | memoryview) -> Frame:
    if len(data) < LARGE:
        return small_frame(bytes(data))
    return LargeFrame([data if isinstance(data, bytes) else memoryview(data)])
