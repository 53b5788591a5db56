"""How much of what was written to a socket the other side does not have yet, where the system tells (Linux).

That is what its system has not acknowledged: what is lost again and again while the network is away, and what
does not fit into its receive buffer while its program does not read.
"""

from __future__ import annotations

import socket
import struct
import sys
from typing import NamedTuple

_UNACKED = 24  # struct tcp_info, linux/tcp.h: segments on their way


class UnsentBytes(NamedTuple):
    """What lies between two programs.

    Attributes:
        waiting: Bytes that were written here and are not there.
        in_flight: Some of them were sent and nobody has acknowledged them: the other side's system should.
    """

    waiting: int
    in_flight: bool


def unsent_bytes(sock: socket.socket) -> UnsentBytes | None:
    """What was written to a TCP connection and is not there yet; None where nobody tells."""
    if sys.platform != "linux":
        return None
    import fcntl
    import termios

    try:
        waiting = struct.unpack("i", fcntl.ioctl(sock, termios.TIOCOUTQ, bytes(4)))[0]
        if not waiting:
            return UnsentBytes(0, False)
        info = sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _UNACKED + 4)
        return UnsentBytes(waiting, struct.unpack_from("I", info, _UNACKED)[0] > 0)
    except (OSError, ValueError, struct.error):
        return None  # closed meanwhile; or a system that was built without it
