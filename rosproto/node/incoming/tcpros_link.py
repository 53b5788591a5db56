"""A link to a publisher over TCPROS: requestTopic, connect, headers, messages.

`protocol.framing` cuts the stream into messages; the socket reads into its buffer. Each system call releases
the GIL and may wait to get it back (5 ms when another thread computes), so the number of calls limits the
speed (docs/performance.md).

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/ROS/Technical Overview (topic negotiation).
"""

from __future__ import annotations

import socket
import struct
import sys
from time import perf_counter, sleep
from typing import TYPE_CHECKING

from rosproto.errors import ConnectionLost, Md5sumMismatch, RemoteProtocolError
from rosproto.node.definitions.topic_type import ANY
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming.publisher_link import PublisherLink
from rosproto.node.incoming.publisher_link_state import LinkEvent
from rosproto.protocol.framing import Decode, FrameDecoder, M
from rosproto.protocol.handshake import (
    HandshakeRefused,
    PublisherReply,
    check_publisher_header,
    subscriber_header,
)
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import connect, expect_data, interrupt, read_header, write_header
from rosproto.transport.uri import format_address

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

FIRST_BUFFER = 4 << 10  # bytes; enough for most topics, and a node may have hundreds

LOOK_AFTER = 32  # messages between two readings of the clock
BURST_GAP_SECONDS = 8e-6  # between the messages of a burst; a round trip takes longer
PAUSE_SECONDS = 100e-6  # without reading in a burst, so that messages gather
MAX_PAUSED_BYTES = 16 << 10  # no pause after a read of this size
NO_PAUSE_SECONDS = 1.0  # without pauses, after pauses that took too long

_length = struct.Struct("<I").unpack_from
# Not on Windows, where WAITALL waits for ever after a reset (and fails on non-blocking sockets).
_WAIT_ALL = getattr(socket, "MSG_WAITALL", 0) if sys.platform != "win32" else 0


class FrameReader:
    """Reads one connection; used by one thread.

    Attributes:
        bytes: Bytes received.
    """

    def __init__(self, sock: socket.socket, limit: int, *, peer: str = "") -> None:
        self._sock = sock
        self._peer = peer
        self._frames = FrameDecoder(limit, room=FIRST_BUFFER)
        self.bytes = 0
        self._looked = perf_counter()
        self._seen = 0  # messages at that time
        self._came = 0  # bytes of the last read
        self._long_pauses = 0
        self._no_pause_until = 0.0

    @property
    def messages(self) -> int:
        """Messages received, including skipped ones."""
        return self._frames.count

    @property
    def skipped(self) -> int:
        """Messages not decoded, since no subscriber keeps that many."""
        return self._frames.passed_over

    def receive(self, decode: Decode[M], owns: bool, newest: int | None = None) -> list[M]:
        """Wait until at least one message is complete; return all that are.

        Args:
            decode: `(buffer, start, end) -> message`.
            owns: True if messages keep parts of the buffer they are decoded from; then each gets a copy.
            newest: Decode only this many of the newest messages; None decodes all.

        Raises:
            ConnectionLost: The publisher closed the connection.
            TooLarge: A frame is longer than `limit`; the stream is unusable.
            CodecError: A message does not fit its definition; the stream is unusable.
            OSError: The connection broke.
        """
        frames = self._frames
        if not frames.buffered:
            # Usually one read brings one message: decode it without looking for others.
            if frames.count - self._seen >= LOOK_AFTER:
                self._look()
            space = frames.space()
            end, buffer = self._sock.recv_into(space), frames.buffer
            if 4 < end < len(buffer) and _length(buffer)[0] == end - 4:
                self._came = end
                self.bytes += end
                frames.count += 1
                if owns:
                    return [decode(bytes(space[4:end]), 0, end - 4)]
                return [decode(buffer, 4, end)]
            self._arrived(end)
        while not (batch := frames.decoded(decode, owns, newest)):
            space = frames.space()
            self._arrived(self._sock.recv_into(space, 0, _WAIT_ALL if frames.is_large else 0))
        return batch

    def _look(self) -> None:
        """In a burst, let messages gather before the next read.

        If the publisher writes each message separately (rospy), waking the reader for each one multiplies the
        cost of a message on both sides.
        """
        now, count = perf_counter(), self._frames.count
        apart, self._looked, self._seen = (now - self._looked) / (count - self._seen), now, count
        if apart < BURST_GAP_SECONDS and self._came < MAX_PAUSED_BYTES and now >= self._no_pause_until:
            sleep(PAUSE_SECONDS)
            self._paused(perf_counter() - now)

    def _paused(self, took: float) -> None:
        """Stop pausing for a while after two pauses longer than a switch interval.

        Then another thread of this process computes, and each pause adds a wait for the GIL.
        """
        self._long_pauses = self._long_pauses + 1 if took > sys.getswitchinterval() else 0
        if self._long_pauses > 1:
            self._no_pause_until = perf_counter() + NO_PAUSE_SECONDS

    def _arrived(self, count: int) -> None:
        if not count:
            left = self._frames.buffered
            inside = f" inside a message ({left} bytes of it arrived)" if left else ""
            text = f"the publisher at {self._peer} closed the connection{inside}"
            raise ConnectionLost(text, peer=self._peer)
        self.bytes += count
        self._came = count
        self._frames.received(count)


# For requestTopic and connecting together: enough for slow networks. A new try is faster than a longer wait,
# since some systems retransmit late after a network failure.
TRY_SECONDS = 5.0


class TcprosLink(PublisherLink):
    """See `PublisherLink`."""

    def __init__(self, subscription: Subscription, uri: str, id: int) -> None:
        super().__init__(subscription, uri, id)
        self._publisher: NodeClient | None = None  # while it is asked for its address
        self._sock: socket.socket | None = None
        self._reader: FrameReader | None = None

    def _open(self) -> None:
        deadline = Deadline(TRY_SECONDS)
        self._connect(*self._tcp_address(self._request_topic([["TCPROS"]], deadline)), deadline)

    def _connect(self, host: str, port: int, deadline: Deadline) -> None:
        self._step(LinkEvent.ADDRESS)
        self.address = format_address(host, port)
        sock = connect(host, port, deadline, hosts=self._context.hosts)
        self._sock = sock
        # The publisher accepted the connection: give a busy one time to answer the header.
        deadline = Deadline(self._context.limits.handshake_seconds)
        sock, reply = self._agree(sock, (host, port), deadline)
        expect_data(sock)
        self._revised = self.subscription.learn(reply, self.uri)
        self.caller_id = reply.callerid
        self._reader = FrameReader(sock, self._context.limits.message_bytes, peer=self.address)

    def _request_topic(self, protocols: list[list[object]], deadline: Deadline) -> list[object]:
        context = self._context
        with NodeClient(self.uri, context.name, limits=context.limits, hosts=context.hosts) as publisher:
            self._publisher = publisher
            try:
                if self.closed:  # before it could be interrupted
                    raise ConnectionLost(f"{self.topic}: the link to {self.uri} is closed", peer=self.uri)
                return publisher.request_topic(self.topic, protocols, timeout=deadline.remaining())
            finally:
                self._publisher = None

    def _tcp_address(self, answer: list[object]) -> tuple[str, int]:
        if len(answer) < 3 or answer[0] != "TCPROS":
            raise ConnectionLost(
                f"{self.topic}: {self.uri} offers no TCPROS connection (answered {str(answer)[:100]});"
                " does it still publish this topic?",
                peer=self.uri,
            )
        host, port = answer[1], answer[2]
        if not isinstance(host, str) or not isinstance(port, int) or not 0 < port < 65536:
            raise RemoteProtocolError(
                f"{self.topic}: {self.uri} answered {str(answer[1:3])[:100]}; expected host and port"
            )
        return host, port

    def _agree(
        self, sock: socket.socket, address: tuple[str, int], deadline: Deadline
    ) -> tuple[socket.socket, PublisherReply]:
        """Exchange headers; request any definition, on a second connection, if the publisher refuses ours.

        Ours comes first: a publisher of this library converts to it, and errors have both md5sums.
        """
        wanted = self.subscription.type
        try:
            return sock, self._exchange_headers(sock, wanted.name, wanted.md5sum, deadline)
        except (Md5sumMismatch, HandshakeRefused) as refusal:
            if wanted.is_wildcard:
                raise
            sock.close()
            sock = connect(*address, deadline, hosts=self._context.hosts)
            self._sock = sock
            reply = self._exchange_headers(sock, ANY, ANY, deadline)
            if reply.md5sum == wanted.md5sum:
                raise refusal  # it was refused for another reason
            return sock, reply

    def _exchange_headers(
        self, sock: socket.socket, type_name: str, md5sum: str, deadline: Deadline
    ) -> PublisherReply:
        write_header(
            sock,
            subscriber_header(
                topic=self.topic,
                type_name=type_name,
                md5sum=md5sum,
                callerid=self._context.name,
                message_definition="" if md5sum == ANY else self.subscription.type.definition,
                tcp_nodelay=self.subscription.tcp_nodelay,
            ),
            deadline,
        )
        header = read_header(sock, self._context.limits, deadline)
        reply = check_publisher_header(
            header, topic=self.topic, type_name=type_name, md5sum=md5sum, peer=self.uri
        )
        self.header = header
        return reply

    def _receive(self) -> None:
        reader, subscription, header, revised = self._reader, self.subscription, self.header, self._revised
        assert reader is not None
        latching = header.get("latching") == "1"
        while True:
            present = subscription.delivery
            delivery = present if revised is None else subscription.delivery_for(revised)
            batch = reader.receive(delivery.decode, delivery.owns, delivery.newest)
            if latching:
                subscription.hand_out(self, delivery, batch, header, revised)
                continue
            if subscription.delivery is not present:
                # A subscriber was added while we waited for this message; it gets the message, too.
                renewed = subscription.delivery if revised is None else subscription.delivery_for(revised)
                renewed.deliver_to_newcomers(delivery, batch, header)
            if len(batch) > 1 or delivery.offer_one is None:
                delivery.deliver(batch, header)
            else:
                # The most frequent case: every call here adds latency.
                message = batch[0]
                message._connection_header = header
                delivery.offer_one(message)

    def _interrupt(self) -> None:
        self._interrupt_request()
        sock = self._sock
        if sock is not None:
            interrupt(sock)

    def _interrupt_request(self) -> None:
        publisher = self._publisher
        if publisher is not None:
            publisher.close()

    def _end_session(self) -> None:
        sock, self._sock = self._sock, None
        if sock is not None:
            sock.close()
        reader, self._reader = self._reader, None
        if reader is not None:
            self._bytes += reader.bytes
            self._messages += reader.messages
            self.subscription.skipped += reader.skipped
        super()._end_session()

    @property
    def skipped(self) -> int:
        reader = self._reader
        return reader.skipped if reader is not None else 0

    def _counters(self) -> tuple[int, int]:
        reader = self._reader
        if reader is None:
            return super()._counters()
        return self._bytes + reader.bytes, self._messages + reader.messages
