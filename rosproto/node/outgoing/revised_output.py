"""The subscribers of one publication that want another revision of its type: encoded once for all of them."""

from __future__ import annotations

import itertools
from typing import Any

from rosproto.codec import AnyMsg, Message
from rosproto.codec.conversion import Conversion
from rosproto.node.outgoing.frames import LargeFrame, small_frame
from rosproto.node.outgoing.outgoing_link import OutgoingLink
from rosproto.node.revisions.topic_types import TopicType

PREFIX = 4  # bytes of the length before a message


class RevisedOutput:
    """One revision and the links that get it.

    Attributes:
        type: The subscribers' revision.
        conversion: From the publication's type to it.
        links: Replaced, never changed, so it is read without a lock.
    """

    def __init__(self, ours: TopicType, theirs: type[Message]) -> None:
        self.type = TopicType(theirs)
        self.conversion = Conversion(ours.message_class, theirs)
        self.links: tuple[OutgoingLink, ...] = ()
        self._ours = ours
        self._seq = itertools.count(1)

    def frame(self, message: Any) -> bytes:
        """A message of ours, or its encoded bytes, as a frame of the revision.

        Raises:
            CodecError: A value does not fit the revision; names the field.
        """
        if isinstance(message, (bytes, bytearray, memoryview, AnyMsg)):  # a relay never decoded it
            data = bytes(message._buff if isinstance(message, AnyMsg) else message)
            message = self._ours.decode(data, 0, len(data))
        body = self.type.encode(self.conversion.convert(message))
        seq = next(self._seq) & 0xFFFFFFFF if self.type.message_class._has_header else None
        return small_frame(body, seq)

    def convert_frame(self, frame: bytes | LargeFrame) -> bytes:
        """A frame that was made for the publication's own type (a latched one)."""
        whole = frame if isinstance(frame, bytes) else frame.owned()
        return self.frame(memoryview(whole)[PREFIX:])

    def send(self, message: Any) -> None:
        """To every link of this revision."""
        frame = self.frame(message)
        for link in self.links:
            link.send(frame)
