"""One published topic of a node: its type, its subscribers, and sending to all of them.

All `Publisher` objects of a node for one topic share one `Publication`. Each is closed separately; the last
one to close unregisters the topic.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/roscpp/Overview/Publishers and Subscribers (latching); roscpp
publication.cpp where they are silent.
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Any

from rosproto.codec import Message
from rosproto.codec.conversion import ConversionError
from rosproto.errors import CodecError, ConnectionLost, Md5sumMismatch, RosError, TooLarge
from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.definitions.md5sum_mismatch import explained, note_differences
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.events import Event, EventKind, is_interrupt, without_frames
from rosproto.node.graph import api_client
from rosproto.node.graph.listening import refuse
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.graph.registrations import RegistrationCall
from rosproto.node.outgoing.frames import (
    ConvertedOutput,
    Frame,
    FrameEncoder,
    LargeFrame,
    OutgoingLink,
    prefix,
    send_frame,
    small_frame,
)
from rosproto.node.outgoing.reconnect import SubscriberReconnect
from rosproto.node.outgoing.subscriber_link import SubscriberLink
from rosproto.node.stats import LinkStats
from rosproto.protocol.framing import BytesLike
from rosproto.protocol.handshake import check_subscriber_header, encode_header, publisher_header
from rosproto.transport.deadline import Deadline, wait_for
from rosproto.transport.uri import format_address

if TYPE_CHECKING:
    from rosproto.node.outgoing.publisher import Publisher

_log = get_logger("rosproto.node")

# Seconds: longest gap between messages of a burst. A tight loop has gaps of 1 to 2 us. A ping between two
# processes on one processor has 5 us and must not wait in a batch.
BURST_GAP = 4e-6
BURST_LENGTH = 8  # messages in a row that make a burst


class Publication:
    """A topic this node publishes (`registration.Registration`).

    Attributes:
        name: Resolved topic.
        type: Its type; the wildcard for a relay that publishes AnyMsg.
        links: Subscribers of our own definition, as an immutable tuple that is replaced as a whole, so it is
            read without a lock. Subscribers of other revisions are in `_revised`, by md5sum.
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
        self._encoder = FrameEncoder(name, type_)
        self._burst = 0
        self._returned = 0.0
        self._plain_class = type_.message_class if self._encoder.is_plain else None
        self._plain_encode: Callable[[Message], bytes] = self._encode_first
        self._revised: dict[str, ConvertedOutput] = {}
        self._closed = False
        self._gone_bytes = 0

    def _encode_first(self, message: Message) -> bytes:
        """Generate the encoder on first use: it takes up to 3 ms, too long for a constructor (`prepare`)."""
        self._plain_encode = self.type.encode
        return self._plain_encode(message)

    # -- master ---------------------------------------------------------------------------------------------

    def registration_call(self) -> RegistrationCall:
        parameters = (self.name, self.type.name, self.context.uri)
        return RegistrationCall("registerPublisher", parameters, api_client.as_str_list)

    def unregister(self, master: MasterClient) -> int:
        return master.unregister_publisher(self.name, self.context.uri)

    # -- handles --------------------------------------------------------------------------------------------

    def add_handle(self, handle: Publisher) -> None:
        """Add a `Publisher` of this topic; the longest requested queue applies to every subscriber."""
        with self._lock:
            self._handles.append(handle)
            size, linger = self.queue_size, self.linger
            for link in self.all_links:
                link.queue_size = size
                link.set_linger(linger)

    def remove_handle(self, handle: Publisher) -> bool:
        """Remove a publisher and its latched message; True if it was the last one."""
        with self._lock:
            if handle in self._handles:
                self._handles.remove(handle)
            self._latched.pop(handle, None)
            return not self._handles

    @property
    def queue_size(self) -> int:
        """Queue length per subscriber."""
        return max((handle.queue_size for handle in self._handles), default=1)

    @property
    def linger(self) -> bool:
        """False if a publisher disabled delivery after the program is killed."""
        return all(handle.linger for handle in self._handles)

    @property
    def handles(self) -> list[Publisher]:
        return list(self._handles)

    @property
    def latching(self) -> bool:
        """True if later subscribers get the last message."""
        return any(handle.latch for handle in self._handles)

    # -- subscribers ----------------------------------------------------------------------------------------

    @property
    def all_links(self) -> tuple[OutgoingLink, ...]:
        """Links of all revisions."""
        if not self._revised:
            return self.links
        return self.links + tuple(link for output in list(self._revised.values()) for link in output.links)

    @property
    def wanted(self) -> list[tuple[OutgoingLink, type[Message]]]:
        """Each link with the class that the subscriber decodes: our own, or its revision's."""
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
            monitor = self.context.link_monitor
        except RosError as error:
            self._refuse(sock, fields, address, error)
            return
        self.prepare(output)  # before the subscriber is visible to publishers
        # The header is sent after the link is added: once the subscriber has read it, it is connected and
        # must get every message published from then on.
        link = SubscriberLink(
            sock,
            fields,
            address=address,
            topic=self.name,
            queue_size=self.queue_size,
            monitor=monitor,
            on_closed=self.link_closed,
            id=self.context.next_link_id(),
            greeting=greeting,
        )
        if not self.linger:
            link.set_linger(False)
        self.attach(link, address, output)

    def prepare(self, output: ConvertedOutput | None = None) -> None:
        """Generate the encoder when a subscriber connects, so that `publish` does not wait for it."""
        (output or self._encoder).prepare()

    def output_for(self, fields: dict[str, str], address: str) -> ConvertedOutput | None:
        """The revision that a subscriber's header asks for; None for our own definition.

        Raises:
            Md5sumMismatch: The requested definition is unknown, or values cannot be converted to it.
            RemoteProtocolError: The header is invalid in another way.
        """
        type_ = self.type
        try:
            check_subscriber_header(
                fields, topic=self.name, type_name=type_.name, md5sum=type_.md5sum, peer=address
            )
            return None
        except Md5sumMismatch as mismatch:
            if type_.is_wildcard or mismatch.remote_type not in ("", type_.name):
                raise
            if not self._has_room(fields["md5sum"]):
                limit = self.context.limits.revisions
                raise TooLarge("revisions", len(self._revised) + 1, limit) from None
            return self._revised.get(fields["md5sum"]) or self._revise(fields, mismatch)

    def _has_room(self, md5sum: str) -> bool:
        """Whether subscribers of this revision are allowed."""
        return md5sum in self._revised or len(self._revised) < self.context.limits.revisions

    def _revise(self, fields: dict[str, str], mismatch: Md5sumMismatch) -> ConvertedOutput:
        definition = fields.get("message_definition", "")
        ours, definitions = self.type.message_class, self.context.definitions
        theirs = definitions.message(ours, fields["md5sum"], definition) or definitions.fetch(
            self.context, self.name, ours, fields["md5sum"]
        )
        if theirs is None:
            raise explained(mismatch, ours, definition) from None
        try:
            output = ConvertedOutput(self.type, theirs)
        except ConversionError as error:
            raise explained(mismatch, ours, definition, str(error)) from error
        who = fields.get("callerid", "a subscriber")
        note_differences(self.context.peer_log, self.name, who, output.conversion)
        return output

    def _refuse(self, sock: socket.socket, fields: dict[str, str], address: str, error: RosError) -> None:
        """Report a refusal to the subscriber, the log and the program; closes the socket."""
        if isinstance(error, (ConnectionLost, TimeoutError)):
            _log.debug("! %s: %s disconnected during the handshake: %s", self.name, address, error)
            sock.close()
            return
        self.context.peer_log.warning(self.name, "! %s: subscriber refused: %s", self.name, error)
        refuse(sock, str(error))
        event = Event(EventKind.REFUSED, self.name, address, without_frames(error), header=fields)
        self.context.events.emit(event)

    def header(self, output: ConvertedOutput | None = None) -> dict[str, str]:
        """Our connection header for a subscriber, with the program's own fields."""
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
            try:
                if handle.header is not None:
                    fields.update(handle.header())
            except BaseException as error:  # as in incoming/subscriber_queue.py
                if is_interrupt(error):
                    raise
                _log.exception("! %s: header() raised", self.name)
        return fields

    def attach(self, link: OutgoingLink, address: str, output: ConvertedOutput | None = None) -> None:
        """Add a subscriber: it gets the latched messages, then everything published from now on."""
        with self._lock:
            # Checked again: several handshakes may have passed the first check at once.
            closed = self._closed or (output is not None and not self._has_room(output.type.md5sum))
            if not closed:
                # Added before the latched messages: a link that fails on the first one removes itself.
                if output is None:
                    self.links = (*self.links, link)
                else:
                    output = self._present(output)
                    output.links = (*output.links, link)
                for frame in self._latched.values():
                    self._send_latched(link, frame, output)
                self._lock.notify_all()
                callbacks = [handle.on_connect for handle in self._handles]
        if closed:
            link.close()
            return
        link.start()
        _log.debug("= %s: %s at %s subscribes", self.name, link.caller_id, address)
        self.context.events.emit(
            Event(EventKind.CONNECTED, self.name, address, peer=link.caller_id, direction="out")
        )
        self._call(callbacks, link.caller_id)

    def _present(self, output: ConvertedOutput) -> ConvertedOutput:
        """The shared output of that revision; it lasts until its last link is detached (`detach`)."""
        return self._revised.setdefault(output.type.md5sum, output)

    def _send_latched(self, link: OutgoingLink, frame: Frame, output: ConvertedOutput | None) -> None:
        if output is not None:
            try:
                frame = output.convert_frame(frame)
            except CodecError as error:  # this subscriber does not get it
                text = "! %s: %s does not get the latched message: %s"
                self.context.peer_log.warning(self.name, text, self.name, link.caller_id, error)
                return
        send_frame(link, frame)

    def _call(self, callbacks: list[Callable[[str], object] | None], caller_id: str) -> None:
        for callback in callbacks:
            try:
                if callback is not None:
                    callback(caller_id)
            except BaseException as error:  # as in incoming/subscriber_queue.py
                if is_interrupt(error):
                    raise
                _log.exception("! %s: a callback for the subscriber %s raised", self.name, caller_id)

    def link_closed(self, link: OutgoingLink, error: ConnectionLost | None) -> None:
        """Handle the end of a link; `error` is the reason, None if we ended it."""
        self.detach(link)
        if isinstance(link, SubscriberLink) and link.reset_ends is not None:
            self._bring_back(link, *link.reset_ends)
        if error is not None:
            self.context.peer_log.info(self.name, "= %s", error)
            kind = EventKind.DISCONNECTED
            self.context.events.emit(
                Event(kind, self.name, error.peer, error, peer=link.caller_id, direction="out")
            )

    def _bring_back(self, link: SubscriberLink, local: tuple[str, int], remote: tuple[str, int]) -> None:
        """Make a subscriber connect again after a reset, which may not have reached it."""

        def is_back() -> bool:
            later = [other for other in self.all_links if other.id > link.id]
            return self._closed or any(other.caller_id == link.caller_id for other in later)

        SubscriberReconnect(
            self.context.lifecycle.closing,
            link.caller_id,
            bind=lambda sock: self.context.listening.endpoints.tcpros.bind_beside(sock, local),
            remote=remote,
            announce=lambda: self.context.registrations.register_again(self),
            is_back=is_back,
        ).start()

    def detach(self, link: OutgoingLink) -> None:
        """Remove a subscriber that is gone and call `on_disconnect`, unless we are closing."""
        with self._lock:
            if link not in self.all_links:
                return
            self._gone_bytes += link.stats().bytes
            self.links = tuple(other for other in self.links if other is not link)
            for md5sum, output in list(self._revised.items()):
                output.links = tuple(other for other in output.links if other is not link)
                if not output.links:
                    del self._revised[md5sum]
            self._lock.notify_all()
            callbacks = [] if self._closed else [handle.on_disconnect for handle in self._handles]
        self._call(callbacks, link.caller_id)

    def wait_for(self, count: int, timeout: float | None) -> bool:
        """Wait until at least `count` subscribers are connected; False after `timeout` seconds."""
        with self._lock:
            return wait_for(self._lock, lambda: self._closed or len(self.all_links) >= count, timeout) and (
                len(self.all_links) >= count
            )

    # -- messages -------------------------------------------------------------------------------------------

    def publish(self, handle: Publisher, message: Any) -> None:
        """Encode a message and send it to every subscriber; see `Publisher.publish`.

        Conversion errors for subscribers of other revisions are raised after all sends.
        """
        links, revised = self.links, self._revised
        if revised:
            self._encoder.check_class(message)
        if links or handle.latch:
            now = perf_counter()
            self._burst = self._burst + 1 if now - self._returned < BURST_GAP else 0
            frame: Frame
            if type(message) is self._plain_class:
                body = self._plain_encode(message)
                frame = prefix(len(body)) + body
            else:
                frame = self._encoder.frame(message)
            if handle.latch:
                links = self._latch(handle, frame)
            waited = True
            if type(frame) is not bytes:
                assert isinstance(frame, LargeFrame)
                for link in links:
                    link.send_large(frame)
            elif self._burst > BURST_LENGTH:
                waited = len(links) > 4
                for link in links:
                    waited |= link.send_soon(frame, now)
            else:
                for link in links:
                    link.send(frame)
            self._returned = perf_counter() if waited else now  # saves reading the clock again
        if revised:
            self._send_converted(message)

    def _send_converted(self, message: Message | BytesLike) -> None:
        """Send a message to the subscribers of other revisions."""
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
        """Keep the frame as latched; return the links that get it now (later ones get it as latched)."""
        if isinstance(frame, LargeFrame):
            frame.owned()
        with self._lock:
            self._latched[handle] = frame
            return self.links

    def send_to(self, caller_id: str, data: bytes) -> bool:
        """Send one encoded message to the newest subscriber of that name; False if there is none."""
        link = next((link for link in reversed(self.links) if link.caller_id == caller_id), None)
        if link is not None:
            link.send(small_frame(data))
        return link is not None

    def flush(self, timeout: float) -> None:
        """Wait until every subscriber's queue is empty."""
        deadline = Deadline(timeout)
        for link in self.all_links:
            link.wait_empty(deadline.remaining() or 0.0)

    def wait_arrived(self, timeout: float) -> bool | None:
        """Wait until every subscriber's computer has received all bytes; None if unknown for one of them."""
        deadline = Deadline(timeout)
        for link in self.all_links:
            pause = 0.0005
            while not (arrived := link.has_arrived()):
                if arrived is None:
                    return None
                if deadline.expired:
                    return False
                time.sleep(pause)
                pause = min(2.0 * pause, 0.02)
        return True

    # -- end ------------------------------------------------------------------------------------------------

    def finish(self, seconds: float) -> None:
        """Wait until the subscribers have read everything, at most `seconds`; nothing more can be sent."""
        deadline = Deadline(seconds)
        try:
            self.flush(seconds)
        except RosError as error:
            _log.debug("! %s: not everything was sent: %s", self.name, error)
        reading = [link for link in self.all_links if link.end_sending()]
        with self._lock:
            wait_for(self._lock, lambda: not set(reading) & set(self.all_links), deadline.remaining())

    def close(self) -> None:
        """End all links; the operating system still delivers the bytes it has accepted."""
        with self._lock:
            self._closed = True
            links = self.all_links
            self._lock.notify_all()
        for link in links:
            link.close()

    def drop_links(self) -> None:
        """Drop all links after our address changed; subscribers connect again at the new one.

        Bytes sent from the old address are discarded: they would arrive late if it came back.
        """
        for link in self.all_links:
            if link.transport == "TCPROS":
                link.close(deliver=False)

    def stats(self) -> list[LinkStats]:
        """One entry per connected subscriber."""
        return [link.stats() for link in self.all_links]

    @property
    def bytes_sent(self) -> int:
        """Bytes sent to all subscribers, including disconnected ones."""
        return self._gone_bytes + sum(link.stats().bytes for link in self.all_links)
