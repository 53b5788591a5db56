"""`Listener`: the listening socket of a gateway, which bounds the connections that are not clients yet.

A connection has a slot here from `accept`, before TLS, until it is a client or closed. So an unfinished
request or an unread refusal takes no client's place; see `ConnectionSlots`.
"""

from __future__ import annotations

import socket
import time
from collections import Counter
from typing import Any

from rosproto.admission import ConnectionSlots, Key
from rosproto.transport.os_errors import max_connections
from rosproto.transport.tcp import reuse_address

READ_BUFFER = 64 << 10
"""Receive buffer of a connection: the most bytes still readable after a reset."""
BACKLOG = 128
AT_ONCE = 8
"""Connections accepted in one turn of the loop. Each is read and answered within five turns, before 40 others
have come: a client that sends its request at once is not pushed out by later ones."""


class Listener(socket.socket):
    """A listening socket, for a loop that calls `accept` (asyncio's selector loop).

    Args:
        host: Address to listen on.
        port: Port, 0 for a free one.
        max_pending: Most connections that are not clients yet.
        refused: Counts closed connections by reason.

    Raises:
        OSError: The address cannot be listened on.
    """

    def __init__(self, host: str, port: int, max_pending: int, refused: Counter[str]) -> None:
        family, *_, address = socket.getaddrinfo(
            host or "0.0.0.0", port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        super().__init__(family, socket.SOCK_STREAM)
        try:
            reuse_address(self)
            if family == socket.AF_INET6:
                self.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, READ_BUFFER)  # accepted sockets inherit it
            self.bind(address[:2])
            self.listen(BACKLOG)
        except OSError:
            self.close()
            raise
        self.slots, self._refused = ConnectionSlots(max_pending), refused
        self.open_ones: set[int] = set()  # descriptors of all connections, clients included

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection; a later one may replace it before it is read."""
        accepted, address = super().accept()
        # With its protocol named, asyncio sets TCP_NODELAY: a short message would wait for the client's
        # acknowledgement of the one before, up to 40 ms.
        connection = _Accepted(self.family, self.type, socket.IPPROTO_TCP, fileno=accepted.detach())
        connection.listener, connection.key = self, key_of(address)
        replaced = self.slots.replaced
        room = max_connections(connection.fileno(), self.open_ones) - len(self.open_ones) + len(self.slots)
        self.open_ones.add(connection.fileno())
        # Always admitted: each slot is replaceable.
        self.slots.admit(connection.key, connection.end, time.monotonic(), max(AT_ONCE, room))
        if self.slots.replaced > replaced:
            self._refused["too many handshakes at a time"] += 1
        return connection, address

    def closed(self, connection: _Accepted) -> None:
        """A connection was closed; one that became a client has no slot any more."""
        if self.slots.release(connection.key, connection.end):
            self._refused["no handshake"] += 1


class _Accepted(socket.socket):
    """An accepted connection that reports its `close` to the listener."""

    listener: Listener
    key: Key

    def end(self) -> None:
        """Shut it down; its reader then closes it."""
        try:
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already

    def close(self) -> None:
        self.listener.open_ones.discard(self.fileno())
        super().close()
        self.listener.closed(self)


def key_of(address: Any) -> Key:
    """The key of a connection in `ConnectionSlots`, from the peer's address; None if it is unknown."""
    return (str(address[0]), int(address[1])) if address else ("?", 0)
