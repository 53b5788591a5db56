"""The publisher's side of a UDPROS connection: a subscriber that gets a topic in datagrams.

Messages are sent in the publisher's own thread while the socket is writable; then the monitor continues, and
the oldest queued message is dropped, as over TCP. Delivery is not reported.

A datagram connection has no visible end. A subscriber is considered gone when its computer rejects the
datagrams (ICMP), when it requests the topic again, or when the master no longer lists it among the topic's
subscribers (checked by the master monitor).

Source: wiki.ros.org/ROS/UDPROS.
"""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterator

from rosproto.errors import ConnectionLost, LocalProtocolError
from rosproto.logs import get_logger
from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.outgoing.link_monitor import LinkMonitor
from rosproto.node.outgoing.publication import Publication
from rosproto.node.outgoing.queued_link import OnClosed, QueuedLink
from rosproto.protocol.udpros import LAST_NUMBER, UDPROS, DatagramAnswer, DatagramRequest, datagrams
from rosproto.transport.deadline import Deadline
from rosproto.transport.udp import open_sender
from rosproto.transport.uri import format_address

_log = get_logger("rosproto.node")

ADDRESS_SECONDS = 2.0  # for the lookup of the subscriber's host name, while it waits for our answer


class DatagramLink(QueuedLink):
    """A subscriber that asked for datagrams (`outgoing_link.OutgoingLink`).

    Args (the others are those of `QueuedLink`):
        sock: Connected to the subscriber's port.
        id: Number of the connection in getBusInfo, and in its datagrams.
        datagram_bytes: The longest datagram.
    """

    transport = UDPROS

    def __init__(
        self,
        sock: socket.socket,
        *,
        caller_id: str,
        address: str,
        topic: str,
        id: int,
        datagram_bytes: int,
        queue_size: int,
        monitor: LinkMonitor,
        on_closed: OnClosed,
    ) -> None:
        super().__init__(
            sock,
            caller_id=caller_id,
            address=address,
            topic=topic,
            id=id,
            queue_size=queue_size,
            monitor=monitor,
            on_closed=on_closed,
        )
        self._datagram_bytes = datagram_bytes
        self._under_way: Iterator[bytes] = iter(())
        self._datagram: bytes | None = None
        self._number = 0

    def set_linger(self, linger: bool) -> None:
        """Ignored: the system does not retransmit datagrams."""

    # -- sending --------------------------------------------------------------------------------------------

    def send(self, frame: bytes) -> None:
        """Send a message now, or queue it until the socket is writable; never waits."""
        with self._lock:
            if self._closed:
                return
            self._queue.put(frame)
            error = None if self._blocked or self._sending else self._drain()
        if error is not None:
            self._fail(error)

    def send_soon(self, frame: bytes, now: float) -> bool:
        """As `send`: a datagram holds one message."""
        self.send(frame)
        return True

    def send_large(self, frame: LargeFrame) -> None:
        """As `send`."""
        self.send(frame.owned())

    def _drain(self) -> OSError | None:
        """Send until the queue is empty or the socket is full; return an error that ends the link."""
        self._sending = True
        try:
            while self._next_datagram():
                assert self._datagram is not None
                try:
                    self._bytes += self.sock.send(self._datagram)
                except BlockingIOError:
                    self._set_blocked(True)
                    return None
                except OSError as error:
                    if error.errno in (errno.ECONNREFUSED, errno.ECONNRESET):
                        return error
                    self._give_up(error)
                self._datagram = None
        finally:
            self._sending = False
        self._set_blocked(False)
        return None

    def _next_datagram(self) -> bool:
        """Put the next one into `_datagram`; False when there is none."""
        while self._datagram is None:
            self._datagram = next(self._under_way, None)
            if self._datagram is None:
                frame = self._queue.pop()
                if frame is None:
                    return False
                self._begin(frame)
        return True

    def _begin(self, frame: bytes) -> None:
        self._number = self._number % LAST_NUMBER + 1
        self._under_way = datagrams(frame, self.id, self._number, self._datagram_bytes)
        try:
            self._datagram = next(self._under_way)
            self._messages += 1
        except LocalProtocolError as error:
            self._give_up(error)

    def _give_up(self, error: Exception) -> None:
        """Drop the rest of a message that is too long, or during a network outage."""
        self._under_way = iter(())
        self._queue.dropped += 1
        if str(error) != self._error:
            self._error = str(error)
            _log.warning("! %s: not sent to %s: %s", self.topic, self.caller_id or self.address, error)

    # -- called by the monitor ------------------------------------------------------------------------------

    def on_readable(self) -> None:
        """Handle an ICMP error from the subscriber's computer. (Subscribers send nothing.)"""
        try:
            self.sock.recv(1)
        except BlockingIOError:
            pass
        except OSError as error:
            self._end(error)

    # -- end ------------------------------------------------------------------------------------------------

    @property
    def _queued(self) -> int:
        return len(self._queue) + (self._datagram is not None)

    def _farewell(self, error: OSError | None) -> str:
        return f"takes no datagrams any more: {error}"


def accept(publication: Publication, request: DatagramRequest, *, links: int) -> list[object]:
    """Accept a subscriber that requests datagrams; from then on it gets messages.

    A repeated request replaces the previous connection.

    Returns:
        The reply of requestTopic.

    Raises:
        Md5sumMismatch, RemoteProtocolError: The header does not fit.
        ConnectionLost, RosTimeout: It cannot be reached, or is not allowed to connect.
    """
    context, fields = publication.context, request.header
    address = format_address(request.host, request.port)
    output, monitor = publication.output_for(fields, address), context.link_monitor
    sock = open_sender(context.hosts.mapped(request.host), request.port, Deadline(ADDRESS_SECONDS))
    peer, own = sock.getpeername()[:2], sock.getsockname()
    why = ""
    if not context.listening.endpoints.tcpros.allows(peer[0]):
        why = f"{peer[0]} is not allowed to connect (allow=)"
    elif links >= context.limits.connections:
        why = f"there are {context.limits.connections} connections already (Limits.connections)"
    if why:
        sock.close()
        raise ConnectionLost(f"{publication.name}: {why}", peer=address)
    for link in publication.all_links:
        if isinstance(link, DatagramLink) and link.caller_id == fields["callerid"]:
            link.close()
    link = DatagramLink(
        sock,
        caller_id=fields["callerid"],
        address=format_address(*peer),
        topic=publication.name,
        id=context.next_link_id(),
        datagram_bytes=request.datagram_bytes,
        queue_size=publication.queue_size,
        monitor=monitor,
        on_closed=publication.link_closed,
    )
    publication.prepare(output)
    publication.attach(link, link.address, output)
    header = publication.header(output)
    return DatagramAnswer(context.listening.host, own[1], link.id, request.datagram_bytes, header).as_answer()
