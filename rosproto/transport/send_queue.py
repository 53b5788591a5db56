"""How much of what was written to a socket the other side does not have yet, where the system tells (Linux).

Over TCP that is what its system has not acknowledged: what is lost again and again while the network is
away, and what does not fit into its receive buffer while its program does not read. On a local socket it is
what its program has not read; the system tells that through its socket monitoring interface, sock_diag(7).
"""

from __future__ import annotations

import os
import socket
import struct
import sys
from typing import NamedTuple

__all__ = ["SendQueue", "send_queue"]

_UNACKED = 24  # struct tcp_info, linux/tcp.h: segments on their way
_NETLINK_SOCK_DIAG, _SOCK_DIAG_BY_FAMILY = 4, 20
_NLM_F_REQUEST = 1
_SHOW_PEER, _SHOW_RQLEN = 4, 16
_PEER, _RQLEN = 2, 4  # attributes of an answer
_ANY = 0xFFFFFFFF
_HEAD = struct.Struct("=IHHII")  # struct nlmsghdr
_ASK = struct.Struct("=BBHIIIII")  # struct unix_diag_req
_TOLD = 16  # bytes of struct unix_diag_msg, before the attributes


class SendQueue(NamedTuple):
    """What lies between two programs.

    Attributes:
        waiting: Bytes that were written here and are not there.
        in_flight: Some of them were sent and nobody has acknowledged them: the other side's system should.
    """

    waiting: int
    in_flight: bool


def send_queue(sock: socket.socket) -> SendQueue | None:
    """What was written to a connected socket and is not there yet; None where nobody tells."""
    if sys.platform != "linux":
        return None
    try:
        if sock.family == socket.AF_UNIX:
            return SendQueue(_unread(sock), False)
        return _of_tcp(sock)
    except (OSError, struct.error):
        return None  # closed meanwhile; or a system that was built without it


def _of_tcp(sock: socket.socket) -> SendQueue | None:
    if sys.platform != "linux":
        return None
    import fcntl
    import termios

    waiting = struct.unpack("i", fcntl.ioctl(sock, termios.TIOCOUTQ, bytes(4)))[0]
    if not waiting:
        return SendQueue(0, False)
    info = sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _UNACKED + 4)
    return SendQueue(waiting, struct.unpack_from("I", info, _UNACKED)[0] > 0)


def _unread(sock: socket.socket) -> int:
    """Bytes in the receive queue of the other end of a local socket."""
    if sys.platform != "linux":
        return 0
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, _NETLINK_SOCK_DIAG) as asking:
        asking.settimeout(1.0)
        (peer,) = struct.unpack("I", _ask(asking, os.fstat(sock.fileno()).st_ino, _SHOW_PEER, _PEER)[:4])
        return int(struct.unpack("I", _ask(asking, peer, _SHOW_RQLEN, _RQLEN)[:4])[0])


def _ask(asking: socket.socket, inode: int, show: int, attribute: int) -> bytes:
    """One attribute of a local socket.

    Raises:
        OSError: The system does not tell.
    """
    if sys.platform != "linux":
        raise OSError("only Linux tells")
    question = _ASK.pack(socket.AF_UNIX, 0, 0, _ANY, inode, show, _ANY, _ANY)
    asking.send(_HEAD.pack(_HEAD.size + len(question), _SOCK_DIAG_BY_FAMILY, _NLM_F_REQUEST, 1, 0) + question)
    answer = asking.recv(4096)
    if _HEAD.unpack_from(answer)[1] == _SOCK_DIAG_BY_FAMILY:
        at = _HEAD.size + _TOLD
        while at + 4 <= len(answer):
            size, kind = struct.unpack_from("=HH", answer, at)
            if kind == attribute:
                return answer[at + 4 : at + size]
            at += max(4, (size + 3) & ~3)
    raise OSError(f"the system tells nothing about the local socket {inode}")
