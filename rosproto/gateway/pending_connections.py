"""`Listener`: the listening socket of a gateway, which bounds the connections that are not clients yet.

A connection counts here from `accept`, before TLS, until it is a client or closed. So an unfinished request
or an unread refusal takes no client's place. When there are too many, the oldest one of the address with the
most is closed: one address cannot lock out others, and among many addresses the newest connections stay.
"""

from __future__ import annotations

import socket
from collections import Counter
from typing import Any

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
        most: Most connections that are not clients yet.
        refused: Counts closed connections by reason.

    Raises:
        OSError: The address cannot be listened on.
    """

    def __init__(self, host: str, port: int, most: int, refused: Counter[str]) -> None:
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
        self._most, self._refused = most, refused
        self._waiting: dict[Any, _Accepted] = {}  # by address and port, the oldest first

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection; it may be closed before it is read."""
        accepted, address = super().accept()
        # With its protocol named, asyncio sets TCP_NODELAY: a short message would wait for the client's
        # acknowledgement of the one before, up to 40 ms.
        connection = _Accepted(self.family, self.type, socket.IPPROTO_TCP, fileno=accepted.detach())
        connection.listener, connection.address = self, address
        self._waiting[address] = connection
        if len(self._waiting) > self._most:
            self._make_room()
        return connection, address

    def _make_room(self) -> None:
        crowd, _ = Counter(address[0] for address in self._waiting).most_common(1)[0]
        oldest = next(address for address in self._waiting if address[0] == crowd)
        self._refused["too many handshakes at a time"] += 1
        self._waiting.pop(oldest).end()

    def answered(self, address: Any) -> None:
        """Its request was refused and counted; it is not closed yet."""
        if address in self._waiting:
            self._waiting[address].answered = True

    def became_client(self, address: Any) -> None:
        """Its handshake has succeeded."""
        self._waiting.pop(address, None)

    def end_waiting(self) -> None:
        """Close all connections that are not clients yet."""
        for connection in self._waiting.values():
            connection.end()

    def closed(self, connection: _Accepted) -> None:
        """A connection was closed."""
        if self._waiting.get(connection.address) is connection:
            del self._waiting[connection.address]
            if not connection.answered:
                self._refused["no handshake"] += 1


class _Accepted(socket.socket):
    """An accepted connection that reports its `close` to the listener."""

    listener: Listener
    address: Any
    answered = False

    def end(self) -> None:
        """Shut it down; its reader then closes it."""
        try:
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already

    def close(self) -> None:
        super().close()
        self.listener.closed(self)
