"""The listening socket of a gateway, and the connections that are no clients yet: which of them makes room.

They count from the moment they are accepted, so before TLS, until they are clients or closed: half a
request, and an answer that is not read, cost a place here and none of the clients'. Where there is no room, a
new connection takes the place of one of the address that has most of them, its oldest. So one address locks
nobody else out, and among many addresses the newest connections stay.
"""

from __future__ import annotations

import socket
from collections import Counter
from typing import Any

from rosproto.transport.tcp import reuse_address

READ_BUFFER = 64 << 10
"""Bytes that the system takes from a client ahead of us: what a reset leaves to be read, at most."""
BACKLOG = 128
AT_ONCE = 8
"""Connections accepted in one turn of the loop. Each is read and answered within five turns, so before 40
others have come: who sends a request at once is not pushed out by those behind him."""


class Listener(socket.socket):
    """A listening socket, for a loop that calls `accept` (asyncio's selector loop).

    Args:
        host: Address to listen on.
        port: Port, 0 for a free one.
        most: How many connections may be no clients yet.
        refused: Counts those that were given up, by reason.

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
            self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, READ_BUFFER)  # accepted ones have it, too
            self.bind(address[:2])
            self.listen(BACKLOG)
        except OSError:
            self.close()
            raise
        self._most, self._refused = most, refused
        self._waiting: dict[Any, _Accepted] = {}  # by their address and port, the oldest first

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection; it may be given up before it is read."""
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
        """Its request was refused, and counted by its reason; it still has to be closed."""
        if address in self._waiting:
            self._waiting[address].answered = True

    def became_client(self, address: Any) -> None:
        """Its handshake is over."""
        self._waiting.pop(address, None)

    def end_waiting(self) -> None:
        """The server ends; who is no client yet will not be one."""
        for connection in self._waiting.values():
            connection.end()

    def closed(self, connection: _Accepted) -> None:
        """One is closed, by whoever held it."""
        if self._waiting.get(connection.address) is connection:
            del self._waiting[connection.address]
            if not connection.answered:
                self._refused["no handshake"] += 1


class _Accepted(socket.socket):
    """A connection that tells when it is closed."""

    listener: Listener
    address: Any
    answered = False

    def end(self) -> None:
        """Shut it down; who reads from it notices, and closes it."""
        try:
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already

    def close(self) -> None:
        super().close()
        self.listener.closed(self)
