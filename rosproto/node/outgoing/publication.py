"""One published topic of a node: its type, its subscribers, and the way of a message to all of them.

Several `Publisher` objects of a node may share one topic; they share this, each closes for itself, and the
last one to close takes the topic off the master.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/roscpp/Overview/Publishers and Subscribers (latching); roscpp
publication.cpp where they are silent.
"""

from __future__ import annotations

import itertools
import socket
import threading
from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol

from rosproto.codec import AnyMsg
from rosproto.codec.conversion import ConversionError
from rosproto.errors import CodecError, ConnectionLost, Md5sumMismatch, RosError, TooLarge
from rosproto.logs import get_logger
from rosproto.node.events import Event, EventKind, without_frames
from rosproto.node.graph import replies
from rosproto.node.graph.registrations import Announcement
from rosproto.node.graph.tcpros_server import refuse
from rosproto.node.outgoing.frames import LARGE, LargeFrame, prefix, small_frame
from rosproto.node.outgoing.revised_output import RevisedOutput
from rosproto.node.outgoing.subscriber_link import SubscriberLink
from rosproto.node.revisions.revisions import explained, note_differences
from rosproto.node.revisions.topic_types import TopicType
from rosproto.protocol.handshake import check_subscriber_header, publisher_header
from rosproto.protocol.header import encode_header
from rosproto.transport.address import format_address
from rosproto.transport.deadline import Deadline
from rosproto.transport.waiting import wait_for

if TYPE_CHECKING:
    from rosproto.codec import Message
    from rosproto.node.context import Context
    from rosproto.node.graph.master_client import MasterClient
    from rosproto.node.outgoing.publisher import Publisher
    from rosproto.node.stats import LinkStats

__all__ = ["OutgoingLink", "Publication"]

_log = get_logger("rosproto.node")

BURST_GAP = 20e-6  # seconds between two publishes that count as a burst
BURST_LENGTH = 8  # messages in a row before a burst is believed

Frame = bytes | LargeFrame
RAW = (bytes, bytearray, memoryview, AnyMsg)
"""What is published as it is, without being decoded: a relay."""


class OutgoingLink(Protocol):
    """A subscriber, over TCP or in this process."""

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

    def close(self, *, deliver: bool = True) -> None: ...

    def stats(self) -> LinkStats: ...


class Publication:
    """A topic this node publishes (`registrations.Registration`).

    Attributes:
        name: Resolved topic.
        type: Its type; the wildcard for a relay that publishes AnyMsg.
        links: The present subscribers that want our own definition; replaced, never changed, so it is read
            without a lock. Those that want another revision are in `_revised`, by md5sum.
    """

    kind = "publisher"

    def __init__(self, context: Context, name: str, type_: TopicType) -> None:
        self.context = context
        self.name = name
        self.type = type_
        self.links: tuple[OutgoingLink, ...] = ()
        self._lock = threading.Condition()
        self._handles: list[Publisher] = []
        self._latched: dict[Publisher, Frame] = {}
        self._has_header = bool(type_.message_class._has_header)
        self._seq = itertools.count(1)
        self._burst = 0
        self._returned = 0.0
        # Most small messages have neither header nor arrays: then encoding is one call.
        is_plain = not self._has_header and not type_.may_be_large and not type_.is_wildcard
        self._plain_class = type_.message_class if is_plain else None
        self._plain_encode: Callable[[Any], bytes] = self._encode_first
        self._revised: dict[str, RevisedOutput] = {}
        self._closed = False
        self._gone_bytes = 0

    def _encode_first(self, message: Any) -> bytes:
        """The encoder takes up to 2 ms to be made, and no constructor waits for that."""
        self._plain_encode = self.type.encode
        return self._plain_encode(message)

    # -- master ---------------------------------------------------------------------------------------------

    def register(self, master: MasterClient) -> None:
        master.register_publisher(self.name, self.type.name, self.context.uri)

    def announce(self) -> Announcement:
        parameters = (self.name, self.type.name, self.context.uri)
        return Announcement("registerPublisher", parameters, replies.as_str_list)

    def unregister(self, master: MasterClient) -> None:
        master.unregister_publisher(self.name, self.context.uri)

    # -- handles --------------------------------------------------------------------------------------------

    def add_handle(self, handle: Publisher) -> None:
        """One more `Publisher` of this topic; the longest queue asked for holds for every subscriber."""
        with self._lock:
            self._handles.append(handle)
            size, linger = self.queue_size, self.linger
            for link in self.all_links:
                link.queue_size = size
                link.set_linger(linger)

    def remove_handle(self, handle: Publisher) -> bool:
        """True when that was the last one; its latched message goes with it."""
        with self._lock:
            if handle in self._handles:
                self._handles.remove(handle)
            self._latched.pop(handle, None)
            return not self._handles

    @property
    def queue_size(self) -> int:
        """Most messages that wait for one subscriber."""
        return max((handle.queue_size for handle in self._handles), default=1)

    @property
    def linger(self) -> bool:
        """False when a publisher wants nothing delivered after the program was killed."""
        return all(handle.linger for handle in self._handles)

    @property
    def handles(self) -> list[Publisher]:
        return list(self._handles)

    @property
    def latching(self) -> bool:
        """True when a late subscriber gets the last message."""
        return any(handle.latch for handle in self._handles)

    # -- subscribers ----------------------------------------------------------------------------------------

    @property
    def all_links(self) -> tuple[OutgoingLink, ...]:
        """Every present subscriber, whatever revision it wants."""
        if not self._revised:
            return self.links
        return self.links + tuple(link for output in list(self._revised.values()) for link in output.links)

    @property
    def wanted(self) -> list[tuple[OutgoingLink, type[Message]]]:
        """Each present subscriber with the class it decodes: our own, or its revision's."""
        own = self.type.message_class
        pairs = [(link, getattr(link, "wanted", None) or own) for link in self.links]
        for output in list(self._revised.values()):
            pairs += [(link, output.type.message_class) for link in output.links]
        return pairs

    def accept(self, sock: socket.socket, fields: dict[str, str], peer: tuple[str, int]) -> None:
        """Answer a subscriber's header; from then on it gets messages. Owns the socket."""
        address = format_address(*peer[:2])
        try:
            output = self.output_for(fields, address)
            greeting = encode_header(self.header(output))
        except RosError as error:
            self._refused(sock, fields, address, error)
            return
        # The header goes out when the link is among the others: one that has read it believes that it is
        # connected, and a message published then must not pass it by.
        link = SubscriberLink(
            sock,
            fields,
            address=address,
            topic=self.name,
            queue_size=self.queue_size,
            monitor=self.context.monitor,
            on_closed=self.link_closed,
            id=self.context.next_link_id(),
            greeting=greeting,
        )
        if not self.linger:
            link.set_linger(False)
        self.attach(link, address, output)

    def output_for(self, fields: dict[str, str], address: str) -> RevisedOutput | None:
        """The revision that a subscriber's header asks for; None for our own definition.

        Raises:
            Md5sumMismatch: It asks for a definition that nobody here knows, or that values cannot be carried
                over to.
            RemoteProtocolError: Something else is wrong with the header.
        """
        try:
            check_subscriber_header(
                fields, topic=self.name, type_name=self.type.name, md5sum=self.type.md5sum, peer=address
            )
            return None
        except Md5sumMismatch as mismatch:
            if self.type.is_wildcard or mismatch.remote_type not in ("", self.type.name):
                raise
            known = self._revised.get(fields["md5sum"])
            if known is None and len(self._revised) >= self.context.limits.revisions:
                raise TooLarge("revisions", len(self._revised) + 1, self.context.limits.revisions) from None
            return known or self._revise(fields, mismatch)

    def _revise(self, fields: dict[str, str], mismatch: Md5sumMismatch) -> RevisedOutput:
        definition = fields.get("message_definition", "")
        ours, revisions = self.type.message_class, self.context.revisions
        theirs = revisions.message(ours, fields["md5sum"], definition) or revisions.fetched.fetch(
            self.context, revisions.learn, self.name, ours, fields["md5sum"]
        )
        if theirs is None:
            raise explained(mismatch, self.type.message_class, definition) from None
        try:
            output = RevisedOutput(self.type, theirs)
        except ConversionError as error:
            raise explained(mismatch, self.type.message_class, definition, str(error)) from error
        note_differences(
            self.context.said, self.name, fields.get("callerid", "a subscriber"), output.conversion
        )
        return output

    def _refused(self, sock: socket.socket, fields: dict[str, str], address: str, error: RosError) -> None:
        if isinstance(error, (ConnectionLost, TimeoutError)):
            _log.debug("! %s: %s went away during the handshake: %s", self.name, address, error)
            sock.close()
            return
        self.context.said.warning(self.name, "! %s: subscriber refused: %s", self.name, error)
        refuse(sock, str(error))
        self.context.emit(Event(EventKind.REFUSED, self.name, address, without_frames(error), header=fields))

    def header(self, output: RevisedOutput | None = None) -> dict[str, str]:
        """What we answer a subscriber."""
        type_ = self.type if output is None else output.type
        fields = publisher_header(
            topic=self.name,
            type_name=type_.name,
            md5sum=type_.md5sum,
            callerid=self.context.name,
            message_definition=type_.definition,
            latching=self.latching,
        )
        for handle in self.handles:
            if handle.header is not None:
                try:
                    fields.update(handle.header())
                except BaseException:  # as in callbacks.py
                    _log.exception("! %s: header() raised", self.name)
        return fields

    def attach(self, link: OutgoingLink, address: str, output: RevisedOutput | None = None) -> None:
        """Add a subscriber: first the latched messages, then everything published from now on."""
        with self._lock:
            closed = self._closed or not self._has_room(output)
            if not closed:
                # Among the others first: a link that ends over its first message takes itself out again.
                if output is None:
                    self.links = (*self.links, link)
                else:
                    output = self._present(output)
                    output.links = (*output.links, link)
                for frame in self._latched.values():
                    self._send_latched(link, frame, output)
                self._lock.notify_all()
                callbacks = [handle._connected for handle in self._handles if handle.on_connect]
        if closed:
            link.close()
            return
        link.start()
        _log.debug("= %s: %s at %s subscribes", self.name, link.caller_id, address)
        self.context.emit(
            Event(EventKind.CONNECTED, self.name, address, peer=link.caller_id, direction="out")
        )
        for callback in callbacks:
            self._call(callback, link.caller_id)

    def _has_room(self, output: RevisedOutput | None) -> bool:
        """Asked again: several handshakes may have been let through at once."""
        if output is None or output.type.md5sum in self._revised:
            return True
        return len(self._revised) < self.context.limits.revisions

    def _present(self, output: RevisedOutput) -> RevisedOutput:
        """The one output of that revision, from now until its last link goes (`detach`)."""
        self.publish = self._publish_revised  # type: ignore[method-assign]
        return self._revised.setdefault(output.type.md5sum, output)

    def _send_latched(self, link: OutgoingLink, frame: Frame, output: RevisedOutput | None) -> None:
        if output is not None:
            try:
                frame = output.convert_frame(frame)
            except CodecError as error:  # published before anybody wanted it so: this one goes without it
                text = "! %s: %s does not get the latched message: %s"
                self.context.said.warning(self.name, text, self.name, link.caller_id, error)
                return
        _send(link, frame)

    def _call(self, callback: Callable[[str], object], caller_id: str) -> None:
        try:
            callback(caller_id)
        except BaseException:  # as in callbacks.py
            _log.exception("! %s: a callback for the subscriber %s raised", self.name, caller_id)

    def link_closed(self, link: OutgoingLink, error: ConnectionLost | None) -> None:
        """A link has ended; `error` says why, None when we ended it."""
        self.detach(link)
        if error is not None:
            self.context.said.info(self.name, "= %s", error)
            kind = EventKind.DISCONNECTED
            self.context.emit(Event(kind, self.name, error.peer, error, peer=link.caller_id, direction="out"))

    def detach(self, link: OutgoingLink) -> None:
        """Forget a subscriber that is gone; who asked to be told is told, but not of our own end."""
        with self._lock:
            if link not in self.all_links:
                return
            self._gone_bytes += link.stats().bytes
            self.links = tuple(other for other in self.links if other is not link)
            for md5sum, output in list(self._revised.items()):
                output.links = tuple(other for other in output.links if other is not link)
                if not output.links:
                    del self._revised[md5sum]
            if not self._revised:
                vars(self).pop("publish", None)
            self._lock.notify_all()
            callbacks = [] if self._closed else [handle.on_disconnect for handle in self._handles]
        for callback in callbacks:
            if callback is not None:
                self._call(callback, link.caller_id)

    def wait_for(self, count: int, timeout: float | None) -> bool:
        """Wait until at least `count` subscribers are connected; False when they were not in time."""
        with self._lock:
            return wait_for(self._lock, lambda: self._closed or len(self.all_links) >= count, timeout) and (
                len(self.all_links) >= count
            )

    # -- messages -------------------------------------------------------------------------------------------

    def publish(self, handle: Publisher, message: Any) -> None:
        """Encode and hand to every subscriber; see `Publisher.publish`.

        While a subscriber wants another revision, `_publish_revised` takes this method's place: otherwise
        nobody asks with every message whether there is one.
        """
        links = self.links
        if not links and not handle.latch:
            return
        now = perf_counter()
        self._burst = self._burst + 1 if now - self._returned < BURST_GAP else 0
        frame: Frame
        if type(message) is self._plain_class:
            body = self._plain_encode(message)
            frame = prefix(len(body)) + body
        else:
            frame = self._encode(message)
        if handle.latch:
            links = self._latch(handle, frame)
        if type(frame) is bytes:
            if self._burst > BURST_LENGTH:
                waited = len(links) > 4
                for link in links:
                    waited |= link.send_soon(frame, now)
                if not waited:  # the clock need not be asked again
                    self._returned = now
                    return
            else:
                for link in links:
                    link.send(frame)
        else:
            assert isinstance(frame, LargeFrame)
            for link in links:
                link.send_large(frame)
        self._returned = perf_counter()

    def _publish_revised(self, handle: Publisher, message: Any) -> None:
        """With subscribers of other revisions: everybody is served before a value's misfit is told."""
        if type(message) is not self.type.message_class and not isinstance(message, RAW):
            self._check_class(message)
        Publication.publish(self, handle, message)
        problem: CodecError | None = None
        for output in list(self._revised.values()):
            if output.links:
                try:
                    output.send(message)
                except CodecError as error:
                    problem = error
        if problem is not None:
            raise problem

    def _latch(self, handle: Publisher, frame: Frame) -> tuple[OutgoingLink, ...]:
        """Remember the frame; the links that are to get it now (those that come later get it as latched)."""
        if isinstance(frame, LargeFrame):
            frame.owned()
        with self._lock:
            self._latched[handle] = frame
            return self.links

    def _encode(self, message: Any) -> Frame:
        """The frame; header.seq is counted per topic and written into the bytes, not into the message."""
        type_ = self.type
        if type_.is_wildcard or type(message) is not type_.message_class:
            if isinstance(message, (bytes, bytearray, memoryview)):
                return _raw_frame(message)  # a relay: nothing is rewritten, header.seq neither (pitfall 59)
            if isinstance(message, AnyMsg):
                return _raw_frame(message._buff)
            self._check_class(message)
        seq = next(self._seq) & 0xFFFFFFFF if self._has_header else None
        if not type_.may_be_large:
            return small_frame(type_.encode(message), seq)
        parts = type_.encode_parts(message)
        if len(parts) == 1 and len(parts[0]) < LARGE:
            return small_frame(bytes(parts[0]), seq)
        frame = LargeFrame(parts, seq)
        return frame if frame.size >= LARGE else frame.owned()

    def _check_class(self, message: Any) -> None:
        """Another class of the same type is as good (another flavour, another copy of the definition)."""
        md5sum = getattr(type(message), "_md5sum", None)
        if md5sum != self.type.md5sum:
            given = getattr(type(message), "_type", None) or type(message).__name__
            raise CodecError(
                f"{self.name} is published as {self.type.name} (md5sum {self.type.md5sum}), not as {given}"
                + (f" (md5sum {md5sum})" if md5sum else "; give a message, its fields, or encoded bytes")
            )

    def send_to(self, caller_id: str, data: bytes) -> bool:
        """Send one encoded message to the newest subscriber of that name; False when it is not there."""
        link = next((link for link in reversed(self.links) if link.caller_id == caller_id), None)
        if link is not None:
            link.send(small_frame(data))
        return link is not None

    def flush(self, timeout: float) -> None:
        """Wait until every subscriber's outbox is empty."""
        deadline = Deadline(timeout)
        for link in self.all_links:
            link.wait_empty(deadline.remaining() or 0.0)

    # -- end ------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End all links; what is in the operating system's hands is still delivered."""
        with self._lock:
            self._closed = True
            links = self.all_links
            self._lock.notify_all()
        for link in links:
            link.close()

    def drop_links(self) -> None:
        """Our address changed: subscribers connect again at the new one.

        What was sent from the old one is thrown away: it would be late if that came back.
        """
        for link in self.all_links:
            if link.transport == "TCPROS":
                link.close(deliver=False)

    def stats(self) -> list[LinkStats]:
        """One entry per present subscriber."""
        return [link.stats() for link in self.all_links]

    @property
    def bytes_sent(self) -> int:
        """Bytes to all subscribers, those that left included."""
        return self._gone_bytes + sum(link.stats().bytes for link in self.all_links)


def _raw_frame(data: bytes | bytearray | memoryview) -> Frame:
    if len(data) < LARGE:
        return small_frame(bytes(data))
    return LargeFrame([data if isinstance(data, bytes) else memoryview(data)])


def _send(link: OutgoingLink, frame: Frame) -> None:
    if isinstance(frame, bytes):
        link.send(frame)
    else:
        link.send_large(frame)
