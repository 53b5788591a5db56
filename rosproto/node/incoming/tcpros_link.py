"""A link to a publisher over TCPROS: requestTopic, connect, headers, messages.

Source: wiki.ros.org/ROS/TCPROS, wiki.ros.org/ROS/Technical Overview (topic negotiation).
"""

from __future__ import annotations

import socket

from rosproto.errors import ConnectionLost, Md5sumMismatch, RemoteProtocolError
from rosproto.node.incoming.frame_reader import FrameReader
from rosproto.node.incoming.link_state import LinkEvent
from rosproto.node.incoming.publisher_link import LinkOwner, PublisherLink
from rosproto.node.revisions.topic_types import ANY
from rosproto.protocol.handshake import (
    HandshakeRefused,
    PublisherReply,
    check_publisher_header,
    subscriber_header,
)
from rosproto.transport.address import format_address
from rosproto.transport.connecting import connect
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import expect_data, interrupt
from rosproto.transport.tcpros_io import read_header, write_header

# For asking and connecting together. Not less, for slow networks; not more, because what was sent into a
# network that was away is repeated late by some systems, and a new question is faster.
TRY_SECONDS = 5.0


class TcprosLink(PublisherLink):
    """See `PublisherLink`."""

    def __init__(self, subscription: LinkOwner, uri: str, id: int) -> None:
        super().__init__(subscription, uri, id)
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
        # The publisher answered the connect, so it lives: give a busy one time to answer the header.
        deadline = Deadline(self._context.limits.handshake_seconds)
        sock, reply = self._agree(sock, (host, port), deadline)
        expect_data(sock)
        self._revised = self.subscription.learn(reply, self.uri)
        self.caller_id = reply.callerid
        self._reader = FrameReader(sock, self._context.limits.message_bytes, peer=self.address)

    def _request_topic(self, protocols: list[list[object]], deadline: Deadline) -> list[object]:
        from rosproto.node.graph.slave_client import NodeClient

        with NodeClient(
            self.uri, self._context.name, limits=self._context.limits, hosts=self._context.hosts
        ) as publisher:
            return publisher.request_topic(self.topic, protocols, timeout=deadline.remaining())

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
                f"{self.topic}: {self.uri} says to connect to {str(answer[1:3])[:100]}, not to host and port"
            )
        return host, port

    def _agree(
        self, sock: socket.socket, address: tuple[str, int], deadline: Deadline
    ) -> tuple[socket.socket, PublisherReply]:
        """Exchange headers; ask a publisher that refuses our definition for its own, on a second connection.

        The wildcard is not asked for at once: a publisher of ours converts to what we want, and errors name
        both sums.
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
        latching = header.get("latching") == "1"  # then `deliver` remembers the message
        plain = revised is None and not latching
        while True:
            present = subscription.delivery
            if plain and present.offer_one is not None:
                reader.receive_singles(present.decode, present.owns, present.offer_one, header, subscription)
                present = subscription.delivery  # what came is for whoever is there now
            delivery = present if revised is None else subscription.delivery_for(revised)
            batch = reader.receive(delivery.decode, delivery.owns, delivery.newest)
            if subscription.delivery is not present:
                # Somebody subscribed while we waited for this, and has been told that the topic is open.
                renewed = subscription.delivery if revised is None else subscription.delivery_for(revised)
                renewed.deliver_to_newcomers(delivery, batch, header)
            if len(batch) > 1 or latching or delivery.offer_one is None:
                delivery.deliver(batch, header, self)
            else:
                # By far the most frequent case: after the wait for a message every call costs its latency.
                message = batch[0]
                message._connection_header = header
                delivery.offer_one(message)

    def _interrupt(self) -> None:
        sock = self._sock
        if sock is not None:
            interrupt(sock)

    def _end_session(self) -> None:
        sock, self._sock = self._sock, None
        if sock is not None:
            sock.close()
        reader, self._reader = self._reader, None
        if reader is not None:
            self._past_bytes += reader.bytes
            self._past_messages += reader.messages
            self.subscription.skipped += reader.skipped
        super()._end_session()

    @property
    def skipped(self) -> int:
        reader = self._reader
        return reader.skipped if reader is not None else 0

    def _counters(self) -> tuple[int, int]:
        reader = self._reader
        return (reader.bytes, reader.messages) if reader is not None else (0, 0)
