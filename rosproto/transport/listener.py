"""`Listener`: the listening socket of a server in an event loop, which bounds the connections that are not
clients yet. (A server with threads: tcp_server.py.)
"""

from __future__ import annotations

import socket
import time
from collections import Counter

from rosproto.transport.connection_slots import ConnectionSlots, Key
from rosproto.transport.os_errors import max_connections
from rosproto.transport.tcp import listen, set_linger

READ_BUFFER = 64 << 10
"""Receive buffer of a connection: the most bytes still readable after a reset."""
BACKLOG, AT_ONCE = 128, 2
"""Connections that wait in the system's queue, and those that are accepted in one turn of the loop. One that
is replaced keeps its file for about five turns, so that ten of the reserved files are in use at a time."""
MIN_PENDING = 5 * AT_ONCE
"""Pending connections, however few files are left. Each is read within five turns of the loop: a client that
sends its request at once is not replaced by later ones."""


class Listener(socket.socket):
    """A listening socket, for a loop that calls `accept` (asyncio's selector loop, not the proactor loop).

    A connection has a slot from `accept`, before TLS, until it is closed, or until the server releases the
    slot because it counts the client elsewhere. So an unfinished request or an unread refusal takes no
    client's place. A connection without a slot is closed before anything is read from it.

    Args:
        host: Address to listen on; "" is 0.0.0.0. "::" is IPv6 alone, on every system.
        port: Port, 0 for a free one.
        slots: Used in the loop only.
        refused: Counts closed connections by reason.

    Raises:
        ConnectionLost: The address cannot be listened on.
    """

    def __init__(
        self, host: str, port: int, slots: ConnectionSlots, refused: Counter[str] | None = None
    ) -> None:
        bound = listen(host.strip("[]") or "0.0.0.0", port, only_ipv6=True)
        super().__init__(bound.family, socket.SOCK_STREAM, socket.IPPROTO_TCP, bound.detach())
        self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, READ_BUFFER)  # accepted sockets inherit it
        self._slots = slots
        self._refused = Counter() if refused is None else refused
        self._open: set[int] = set()  # descriptors of all connections, clients included

    def listen(self, backlog: int = BACKLOG) -> None:
        """Listen with our own queue: the loop passes the number that it accepts at once."""
        super().listen(BACKLOG)

    def accept(self) -> tuple[socket.socket, tuple[str, int]]:
        """Accept the next connection that gets a slot; a later one may replace it before it is read."""
        while True:
            accepted, address = super().accept()
            connection = _Accepted(accepted.family, accepted.type, accepted.proto, fileno=accepted.detach())
            connection.listener, connection.key = self, key_of(address)
            connection.send_at_once()
            others = len(self._open) - len(self._slots)  # clients, and those that were replaced just now
            limit = max_connections(connection.fileno(), self._open) - others
            self._open.add(connection.fileno())
            before, now = self._slots.replaced, time.monotonic()
            admitted = self._slots.admit(connection.key, connection.end, now, max(MIN_PENDING, limit))
            if self._slots.replaced > before:
                self._refused["too many handshakes at a time"] += self._slots.replaced - before
            if admitted:
                return connection, address
            connection.end()
            connection.close()

    def closed(self, connection: _Accepted, descriptor: int) -> None:
        """A connection was closed; one that became a client of a gateway has no slot any more."""
        self._open.discard(descriptor)
        if self._slots.release(connection.key, connection.end):
            self._refused["no handshake"] += 1


class _Accepted(socket.socket):
    """An accepted connection that reports its `close` to the listener."""

    listener: Listener
    key: Key

    def send_at_once(self) -> None:
        """Let no short message wait for the client's acknowledgement of the one before, up to 40 ms."""
        try:
            self.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError:
            pass  # the client has closed it already

    def end(self) -> None:
        """Shut the connection down and drop what it has not read; its reader then closes it."""
        set_linger(self, False)
        try:
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already

    def close(self) -> None:
        """Close the socket and free its slot."""
        descriptor = self.fileno()
        super().close()
        self.listener.closed(self, descriptor)


def key_of(address: tuple[str, int] | None) -> Key:
    """The key of a connection in `ConnectionSlots`, from the peer's address."""
    return (address[0], address[1]) if address else ("?", 0)  # IPv6 addresses have two more parts
