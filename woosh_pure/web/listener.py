"""The socket that the server listens at: a connection without a place is closed before anything is read."""

from __future__ import annotations

import errno
import os
import socket
import struct
import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from woosh_pure.web.connection_slots import ConnectionSlots, Key

__all__ = ["Listener"]

_NO_LINGER = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)


class Listener(socket.socket):
    """Listens at once.

    Raises:
        OSError: The address cannot be listened at; the text says what to do.
    """

    def __init__(self, bind: str, port: int, slots: ConnectionSlots) -> None:
        host = bind.strip("[]")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        # The protocol is named because asyncio sends small messages at once only where it is (TCP_NODELAY).
        super().__init__(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        self._slots = slots
        try:
            if hasattr(socket, "SO_REUSEADDR") and os.name == "posix":
                self.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self.bind((host, port))
            self.listen(128)
        except OSError as error:
            self.close()
            raise OSError(
                error.errno or errno.EINVAL,
                f"cannot listen at {bind} port {port}: {error.strerror or error}; give another --port",
            ) from error

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection that has a place."""
        while True:
            accepted, address = super().accept()
            connection = _Connection(accepted.family, accepted.type, accepted.proto, fileno=accepted.detach())
            connection.key, connection.slots = (str(address[0]), int(address[1])), self._slots
            if self._slots.admit(connection.key, connection.end, time.monotonic()):
                return connection, address
            connection.end()
            connection.close()


class _Connection(socket.socket):
    """Gives its place back when it is closed."""

    key: Key
    slots: ConnectionSlots

    def end(self) -> None:
        """End it from our side; whoever reads it sees that, and closes it."""
        try:
            self.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended by itself

    def close(self) -> None:
        """Close, and leave."""
        super().close()
        self.slots.closed(self.key, self.end)
