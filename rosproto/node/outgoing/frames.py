"""Encode published messages to frames: small ones as one `bytes`, large ones in parts without a copy.

A TCPROS message is its uint32 length and its body (wiki.ros.org/ROS/TCPROS).
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Sequence
from typing import Any, Protocol

from rosproto.codec import AnyMsg, Message, encode_parts, prepare
from rosproto.codec.conversion import Conversion
from rosproto.errors import CodecError
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.stats import LinkStats
from rosproto.protocol.framing import BytesLike

LARGE = 32 << 10  # bytes; below this one copy costs less than a second system-call argument
prefix = struct.Struct("<I").pack
_prefix_and_seq = struct.Struct("<II").pack

Part = bytes | memoryview


def small_frame(body: bytes, seq: int | None = None) -> bytes:
    """Length and body in one `bytes`; `seq` replaces the first field (header.seq)."""
    if seq is None:
        return prefix(len(body)) + body
    return _prefix_and_seq(len(body), seq) + body[4:]


class LargeFrame:
    """A message in parts, some of them the caller's own arrays.

    Valid until `publish()` returns; unsent parts are kept in one copy (`owned`) that all links share.

    Attributes:
        views: Length, then the body, as byte views.
        size: Total bytes, including the length.
    """

    __slots__ = ("_owned", "size", "views")

    def __init__(self, parts: Sequence[Part], seq: int | None = None) -> None:
        views = [memoryview(part).cast("B") for part in parts]
        size = sum(view.nbytes for view in views)
        if size > 0xFFFFFFFF:
            raise CodecError(f"a message of {size} bytes is too long: TCPROS allows at most 4294967295")
        if seq is None:
            views.insert(0, memoryview(prefix(size)))
        else:  # a Header and the fields after it are one part, so the first part contains seq
            views[:1] = [memoryview(_prefix_and_seq(size, seq)), views[0][4:]]
        self.views = [view for view in views if view.nbytes]
        self.size = size + 4
        self._owned: bytes | None = None

    def owned(self) -> bytes:
        """The whole frame as a copy (made once)."""
        if self._owned is None:
            self._owned = b"".join(self.views)
        return self._owned

    def __len__(self) -> int:
        return self.size

    def frozen(self) -> LargeFrame | bytes:
        """This frame if its memory is immutable, else a copy; valid after `publish()` returns."""
        if self._owned is None and all(map(_is_immutable, self.views)):
            return self
        return self.owned()

    def rest(self, sent: int) -> list[memoryview]:
        """The bytes after the first `sent`, in immutable memory."""
        if self._owned is not None:
            return [memoryview(self._owned)[sent:]]
        rest = remaining(self.views, sent)
        if all(_is_immutable(view) for view in rest):
            return rest
        return [memoryview(b"".join(rest))]


def remaining(views: Sequence[memoryview], sent: int) -> list[memoryview]:
    """The views without their first `sent` bytes."""
    rest = []
    for view in views:
        if sent >= view.nbytes:
            sent -= view.nbytes
        else:
            rest.append(view[sent:])
            sent = 0
    return rest


def _is_immutable(view: memoryview) -> bool:
    """True if the memory belongs to a `bytes`: a read-only array may be a view of a writable one."""
    owner: object = view.obj
    while owner is not None and not isinstance(owner, bytes):
        owner = owner.obj if isinstance(owner, memoryview) else getattr(owner, "base", None)
    return isinstance(owner, bytes)


Frame = bytes | LargeFrame


class OutgoingLink(Protocol):
    """Interface of a link to a subscriber: over TCP, in datagrams, or in this process."""

    id: int
    caller_id: str
    queue_size: int
    transport: str

    def start(self) -> None: ...

    def set_linger(self, linger: bool) -> None: ...

    def send(self, frame: bytes) -> None: ...

    def send_soon(self, frame: bytes, now: float) -> bool: ...

    def send_large(self, frame: LargeFrame) -> None: ...

    def wait_empty(self, timeout: float) -> None: ...

    def has_arrived(self) -> bool | None:
        """Whether the subscriber's computer has received all bytes; None if unknown."""

    def end_sending(self) -> bool:
        """Say that nothing more comes; return whether the subscriber disconnects when it has read that."""

    def close(self, *, deliver: bool = True) -> None: ...

    def stats(self) -> LinkStats: ...


def send_frame(link: OutgoingLink, frame: Frame) -> None:
    """Send a small or large frame now."""
    if isinstance(frame, bytes):
        link.send(frame)
    else:
        link.send_large(frame)


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
        """Whether the type has neither header nor arrays, so that encoding is one call."""
        return not self._has_header and not self._type.may_be_large and not self._type.is_wildcard

    def prepare(self) -> None:
        """Generate the encoder in advance, so that the first message does not wait."""
        prepare(self._type.message_class, parts=self._type.may_be_large)

    def frame(self, message: Any) -> Frame:
        """The frame of a message, or of its encoded bytes.

        Raises:
            CodecError: A value does not fit its field, or the message is of another type.
        """
        type_ = self._type
        if type_.is_wildcard or type(message) is not type_.message_class:
            if isinstance(message, (bytes, bytearray, memoryview)):
                return _raw_frame(message)  # a relay: the bytes stay unchanged
            if isinstance(message, AnyMsg):
                return _raw_frame(message._buff)
            self.check_class(message)
        seq = next(self._seq) & 0xFFFFFFFF if self._has_header else None
        if not type_.may_be_large:
            return small_frame(type_.encode(message), seq)
        parts = encode_parts(message)
        if len(parts) == 1 and len(parts[0]) < LARGE:
            return small_frame(bytes(parts[0]), seq)
        frame = LargeFrame(parts, seq)
        return frame if frame.size >= LARGE else frame.owned()

    def check_class(self, message: object) -> None:
        """Accept any class of the same type (another value style, another copy of the definition).

        Raises:
            CodecError: The message is of another type.
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


def _raw_frame(data: BytesLike) -> Frame:
    if len(data) < LARGE:
        return small_frame(bytes(data))
    return LargeFrame([data if isinstance(data, bytes) else memoryview(data)])


class ConvertedOutput:
    """One revision and the links that get it: a message is encoded once for all of them.

    Attributes:
        type: The subscribers' revision.
        conversion: From the publication's type to `type`.
        links: An immutable tuple that is replaced as a whole, so it is read without a lock.
    """

    def __init__(self, ours: TopicType, theirs: type[Message]) -> None:
        self.type = TopicType(theirs)
        self.conversion = Conversion(ours.message_class, theirs)
        self.links: tuple[OutgoingLink, ...] = ()
        self._ours = ours
        self._seq = itertools.count(1)

    def prepare(self) -> None:
        """As `FrameEncoder.prepare`."""
        prepare(self.type.message_class)

    def frame(self, message: Message | BytesLike) -> bytes:
        """Convert one of our messages, or its encoded bytes, to a frame of the revision.

        Raises:
            CodecError: A value does not fit the revision; the text names the field.
        """
        if isinstance(message, (bytes, bytearray, memoryview, AnyMsg)):  # from a relay, not decoded yet
            data = bytes(message._buff if isinstance(message, AnyMsg) else message)
            message = self._ours.decode(data, 0, len(data))
        body = self.type.encode(self.conversion.convert(message))
        seq = next(self._seq) & 0xFFFFFFFF if self.type.message_class._has_header else None
        return small_frame(body, seq)

    def convert_frame(self, frame: bytes | LargeFrame) -> bytes:
        """Convert a frame of the publication's own type (a latched one)."""
        whole = frame if isinstance(frame, bytes) else frame.owned()
        return self.frame(memoryview(whole)[4:])

    def send(self, message: Message | BytesLike) -> None:
        """Send a message to every link of this revision."""
        frame = self.frame(message)
        for link in self.links:
            link.send(frame)
