"""How many bytes written to a TCP socket the peer has not received yet (Linux only).

Received means acknowledged by the peer's system. The rest is retransmitted while the network is down, or does
not fit into the peer's receive buffer while its program does not read.
"""

from __future__ import annotations

import socket
import struct
import sys
from typing import NamedTuple

if sys.platform == "linux":  # with this module: later, no file may be left to read them from
    import fcntl
    import termios

# struct tcp_info, linux/tcp.h: the state of congestion control (0: nothing is lost), unacknowledged segments
_CA_STATE = 1
_UNACKED = 24


class UnsentBytes(NamedTuple):
    """The bytes between two programs.

    Attributes:
        waiting: Bytes written here and not acknowledged.
        in_flight: Some of them were sent and are not acknowledged yet, so the peer's system should reply.
        repairing: The system sends lost bytes again, or has done so and waits for the acknowledgement.
    """

    waiting: int
    in_flight: bool
    repairing: bool = False


def unsent_bytes(sock: socket.socket) -> UnsentBytes | None:
    """The unacknowledged bytes of a TCP connection; None where the system does not provide them."""
    if sys.platform == "linux":
        try:
            waiting = struct.unpack("i", fcntl.ioctl(sock, termios.TIOCOUTQ, bytes(4)))[0]
            if not waiting:
                return UnsentBytes(0, False)
            info = sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _UNACKED + 4)
            return UnsentBytes(waiting, struct.unpack_from("I", info, _UNACKED)[0] > 0, info[_CA_STATE] > 0)
        except (OSError, ValueError, struct.error):
            pass  # closed meanwhile, or not supported by this kernel
    return None
