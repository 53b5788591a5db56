"""Replies to a subscriber's connection header: our header, in the requested definition, or an error.

Source: wiki.ros.org/ROS/TCPROS.
"""

from __future__ import annotations

import itertools
import socket
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rosproto.codec import AnyMsg, Message, prepare
from rosproto.codec.conversion import Conversion, ConversionError
from rosproto.errors import ConnectionLost, Md5sumMismatch, RosError, TooLarge
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.md5sum_mismatch import explained, note_differences
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.events import Event, EventKind, is_interrupt, without_frames
from rosproto.node.graph.listening import refuse
from rosproto.node.outgoing.frames import LargeFrame, OutgoingLink, small_frame
from rosproto.protocol.handshake import check_subscriber_header, publisher_header

_log = get_logger("rosproto.node")


PREFIX = 4  # bytes of the length before a message


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

    def frame(self, message: Any) -> bytes:
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
        return self.frame(memoryview(whole)[PREFIX:])

    def send(self, message: Any) -> None:
        """Send a message to every link of this revision."""
        frame = self.frame(message)
        for link in self.links:
            link.send(frame)


class HandshakeReplies:
    """The publisher's side of the handshake, for one topic.

    Args:
        context: Context of the node.
        topic: Resolved topic.
        type: Published type.
        revised: The publication's outputs for other definitions with subscribers, by md5sum.
    """

    def __init__(
        self, context: Context, topic: str, type: TopicType, revised: Mapping[str, ConvertedOutput]
    ) -> None:
        self._context = context
        self._topic = topic
        self._type = type
        self._revised = revised

    def output_for(self, fields: dict[str, str], address: str) -> ConvertedOutput | None:
        """The revision that a subscriber's header asks for; None for our own definition.

        Raises:
            Md5sumMismatch: The requested definition is unknown, or values cannot be converted to it.
            RemoteProtocolError: The header is invalid in another way.
        """
        type_ = self._type
        try:
            check_subscriber_header(
                fields, topic=self._topic, type_name=type_.name, md5sum=type_.md5sum, peer=address
            )
            return None
        except Md5sumMismatch as mismatch:
            if type_.is_wildcard or mismatch.remote_type not in ("", type_.name):
                raise
            known = self._revised.get(fields["md5sum"])
            if known is None and not self.has_room():
                most = self._context.limits.revisions
                raise TooLarge("revisions", len(self._revised) + 1, most) from None
            return known or self._revise(fields, mismatch)

    def has_room(self) -> bool:
        """Whether one more definition is allowed."""
        return len(self._revised) < self._context.limits.revisions

    def _revise(self, fields: dict[str, str], mismatch: Md5sumMismatch) -> ConvertedOutput:
        definition = fields.get("message_definition", "")
        ours, revisions = self._type.message_class, self._context.revisions
        theirs = revisions.message(ours, fields["md5sum"], definition) or revisions.fetch(
            self._context, self._topic, ours, fields["md5sum"]
        )
        if theirs is None:
            raise explained(mismatch, ours, definition) from None
        try:
            output = ConvertedOutput(self._type, theirs)
        except ConversionError as error:
            raise explained(mismatch, ours, definition, str(error)) from error
        who = fields.get("callerid", "a subscriber")
        note_differences(self._context.peer_log, self._topic, who, output.conversion)
        return output

    def refused(self, sock: socket.socket, fields: dict[str, str], address: str, error: RosError) -> None:
        """Report a refusal to the subscriber, the log and the program; closes the socket."""
        context, topic = self._context, self._topic
        if isinstance(error, (ConnectionLost, TimeoutError)):
            _log.debug("! %s: %s went away during the handshake: %s", topic, address, error)
            sock.close()
            return
        context.peer_log.warning(topic, "! %s: subscriber refused: %s", topic, error)
        refuse(sock, str(error))
        context.events.emit(Event(EventKind.REFUSED, topic, address, without_frames(error), header=fields))

    def header(
        self,
        output: ConvertedOutput | None,
        *,
        latching: bool,
        more: Iterable[Callable[[], Mapping[str, str]]] = (),
    ) -> dict[str, str]:
        """Our header for a subscriber; `more` returns the program's own fields."""
        type_ = self._type if output is None else output.type
        fields = publisher_header(
            topic=self._topic,
            type_name=type_.name,
            md5sum=type_.md5sum,
            callerid=self._context.name,
            message_definition=type_.definition,
            latching=latching,
        )
        for give in more:
            try:
                fields.update(give())
            except BaseException as error:  # as in incoming/subscriber_queue.py
                if is_interrupt(error):
                    raise
                _log.exception("! %s: header() raised", self._topic)
        return fields
