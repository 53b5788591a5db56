"""The listening socket. A connection for which there is no slot is closed before anything is read from it."""

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
    """A listening socket; it listens from the start.

    Raises:
        OSError: Listening on this address failed; the message says what to do.
    """

    def __init__(self, bind: str, port: int, slots: ConnectionSlots) -> None:
        host = bind.strip("[]")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        # asyncio sets TCP_NODELAY only if the listening socket names its protocol.
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
        """The next connection that gets a slot."""
        while True:
            accepted, address = super().accept()
            connection = _Connection(accepted.family, accepted.type, accepted.proto, fileno=accepted.detach())
            connection.key, connection.slots = (str(address[0]), int(address[1])), self._slots
            if self._slots.admit(connection.key, connection.end, time.monotonic()):
                return connection, address
            connection.end()
            connection.close()


class _Connection(socket.socket):
    """A connection that gives its slot back when it is closed."""

    key: Key
    slots: ConnectionSlots

    def end(self) -> None:
        """Shut it down from our side. Whoever reads from it notices, and closes it."""
        try:
            self.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already

    def close(self) -> None:
        """Close the socket and free its slot."""
        super().close()
        self.slots.closed(self.key, self.end)
