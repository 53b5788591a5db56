"""A link to a publisher by datagrams (UDPROS); over TCPROS if the publisher does not offer datagrams.

After a network failure TCP delivers all sent messages, oldest first. Here lost messages stay lost, and the
next message is a current one.

The end of a datagram connection is not visible. After `QUIET_SECONDS` without a datagram, the link asks
whether the publisher still lists it; a restarted one does not.

Source: wiki.ros.org/ROS/UDPROS.
"""

from __future__ import annotations

import socket
from time import monotonic
from typing import TYPE_CHECKING

from rosproto.errors import CodecError, ConnectionLost, MasterError, TooLarge
from rosproto.node.definitions.topic_type import ANY
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming.publisher_link_state import LinkEvent
from rosproto.node.incoming.tcpros_link import TRY_SECONDS, TcprosLink
from rosproto.node.stats import LinkStats
from rosproto.protocol.handshake import check_publisher_header, subscriber_header
from rosproto.protocol.udpros import DATAGRAM_BYTES, UDPROS, DatagramAnswer, DatagramRequest, Reassembly
from rosproto.transport.deadline import Deadline
from rosproto.transport.udp import open_receiver
from rosproto.transport.uri import format_address

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

QUIET_SECONDS = 3.0  # without a datagram, before the publisher is asked
LATE_SECONDS = 0.5
MAX_DATAGRAM_BYTES = 1 << 16  # the limit of UDP for a datagram


class UdprosLink(TcprosLink):
    """See `PublisherLink`; the publisher chooses datagrams or TCP for each session."""

    def __init__(self, subscription: Subscription, uri: str, id: int) -> None:
        super().__init__(subscription, uri, id)
        self._datagrams: Reassembly | None = None
        self._past_lost = 0
        self._broken_off = False

    def _open(self) -> None:
        deadline = Deadline(TRY_SECONDS)
        self.transport, self._broken_off = UDPROS, False
        self._sock = sock = open_receiver(self._context.listening.endpoints.tcpros.host)
        answer = self._ask(sock.getsockname()[1], deadline)
        if answer and answer[0] == UDPROS:
            self._agreed(DatagramAnswer.parse(answer))
            return
        self.transport, self._sock = "TCPROS", None
        sock.close()
        self._connect(*self._tcp_address(answer), deadline)

    def _ask(self, port: int, deadline: Deadline) -> list[object]:
        """Request our definition; if the publisher refuses it, request any."""
        wanted = self.subscription.type
        try:
            return self._request(port, wanted.name, wanted.md5sum, deadline)
        except MasterError:
            if wanted.is_wildcard:
                raise
            return self._request(port, ANY, ANY, deadline)

    def _request(self, port: int, type_name: str, md5sum: str, deadline: Deadline) -> list[object]:
        header = subscriber_header(
            topic=self.topic,
            type_name=type_name,
            md5sum=md5sum,
            callerid=self._context.name,
            message_definition="" if md5sum == ANY else self.subscription.type.definition,
        )
        offer = DatagramRequest(header, self._context.listening.host, port, DATAGRAM_BYTES)
        return self._request_topic([offer.as_protocol(), ["TCPROS"]], deadline)

    def _agreed(self, answer: DatagramAnswer) -> None:
        """Check the publisher's header in its answer, and begin the session."""
        self._step(LinkEvent.ADDRESS)
        self.address = format_address(answer.host, answer.port)
        wanted = self.subscription.type
        own = answer.header.get("md5sum") == wanted.md5sum
        reply = check_publisher_header(
            answer.header,
            topic=self.topic,
            type_name=wanted.name if own else ANY,
            md5sum=wanted.md5sum if own else ANY,
            peer=self.uri,
        )
        self._revised = self.subscription.learn(reply, self.uri)
        self._datagrams = Reassembly(answer.connection, self._context.limits.message_bytes)
        self.header = answer.header
        self.caller_id = reply.callerid

    # -- the session ----------------------------------------------------------------------------------------

    def _receive(self) -> None:
        if self._datagrams is None:
            super()._receive()
            return
        sock = self._sock
        assert sock is not None
        sock.settimeout(QUIET_SECONDS)
        warned = False
        while True:
            try:
                datagram = sock.recv(MAX_DATAGRAM_BYTES)
            except TimeoutError:
                self._ask_whether_connected(sock)
                continue
            if self._broken_off or self.closed:
                raise ConnectionLost(
                    f"{self.topic}: the link to {self.address} was closed on this side", peer=self.address
                )
            try:
                self._take(datagram)
            except (CodecError, TooLarge) as error:
                # Any computer can send a datagram: drop it and keep the connection.
                if not warned:
                    warned = True
                    text = "! %s: a datagram from %s is dropped: %s"
                    self._context.peer_log.warning(self.topic, text, self.topic, self.caller_id, error)
                    self.subscription.report(error)

    def _take(self, datagram: bytes) -> None:
        assert self._datagrams is not None
        self._bytes += len(datagram)
        body = self._datagrams.add(datagram)
        if body is None:
            return
        self._messages += 1
        subscription, revised = self.subscription, self._revised
        delivery = subscription.delivery if revised is None else subscription.delivery_for(revised)
        batch = [delivery.decode(body, 0, len(body))]
        subscription.hand_out(self, delivery, batch, self.header, revised)

    def _ask_whether_connected(self, sock: socket.socket) -> None:
        """Raise ConnectionLost if the publisher is gone or does not list our connection.

        Datagrams that arrived during a slow answer are late, and are skipped.
        """
        began = monotonic()
        with NodeClient(
            self.uri, self._context.name, limits=self._context.limits, hosts=self._context.hosts
        ) as publisher:
            connections = publisher.get_bus_info(timeout=QUIET_SECONDS)
        if not any(
            row.topic == self.topic and row.transport == UDPROS and row.destination == self._context.name
            for row in connections
        ):
            raise ConnectionLost(
                f"{self.topic}: {self.caller_id} at {self.uri} no longer sends here; was it restarted?",
                peer=self.address,
            )
        if monotonic() - began > LATE_SECONDS:
            sock.setblocking(False)
            try:
                while True:
                    self._bytes += len(sock.recv(MAX_DATAGRAM_BYTES))
            except BlockingIOError:
                sock.settimeout(QUIET_SECONDS)

    # -- end ------------------------------------------------------------------------------------------------

    def _interrupt(self) -> None:
        if self.transport != UDPROS:
            super()._interrupt()
            return
        self._broken_off = True
        self._interrupt_request()
        sock = self._sock
        if sock is not None:
            try:
                # The only portable way to wake a thread that waits for datagrams.
                sock.sendto(b"", sock.getsockname())
            except OSError:
                pass  # closed meanwhile

    def _end_session(self) -> None:
        datagrams, self._datagrams = self._datagrams, None
        if datagrams is not None:
            self._past_lost += datagrams.lost
        super()._end_session()

    def stats(self) -> LinkStats:
        """Counters over all sessions; `dropped` counts lost messages."""
        stats = super().stats()
        datagrams = self._datagrams
        stats.dropped = self._past_lost + (0 if datagrams is None else datagrams.lost)
        return stats
