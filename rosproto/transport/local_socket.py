"""The short way to a TCPROS port of the same computer: a socket of Linux's abstract kind, named after it.

TCP does for every message, also over loopback, what a network needs: segments, acknowledgements, timers. A
Twist that another process of ours echoes is back after 48 to 59 us, by TCP after 67 to 82 (medians of three
runs); with a LaserScan of 720 ranges the two cannot be told apart. So whoever listens on a TCPROS port also
listens on a Unix socket that has the port's address as its name, and whoever connects to an address tries
that name first. Names belong to a network namespace, as addresses do: one that is there is the port meant.
The bytes are the same.

It is there only on Linux, and only where the system lets a sender be far ahead (4 MB, as newer ones do):
what a slow receiver has not taken waits there, as it would in TCP's buffers. Everybody else (rospy, roscpp,
another computer) uses the port.

What was written to it lies with the receiver at once, and a receiver that stopped for a while reads it all
when it goes on, also from a sender that has left. So a sender can say that what was not read is void: it
ends the direction that nobody uses, to itself, and leaves the socket open (`make_void`). A receiver that
comes back after a pause looks for that before it takes what it has read.
"""

from __future__ import annotations

import os
import select
import socket
import struct
import sys
from time import monotonic
from typing import Any

from rosproto.errors import ConnectionLost
from rosproto.transport.address import format_address

__all__ = ["connect_locally", "has_left", "listen_locally", "make_void", "name_of", "widen"]

_BACKLOG = 64
_PREFIX = "\0rosproto "  # the zero byte makes the name abstract: no file, gone with the socket
_AHEAD = 4 << 20  # bytes; net.core.wmem_max
_PAUSE = 3.0  # seconds between two reads, after which it is looked
_CREDENTIALS = struct.Struct("iII")  # SO_PEERCRED: process, user, group


def listen_locally(listener: socket.socket) -> socket.socket | None:
    """A listening socket beside that of a port; None where there is no such thing, or the name is taken."""
    sock = _make()
    if sock is None:
        return None
    try:
        if widen(sock):
            sock.bind(_PREFIX + format_address(*listener.getsockname()[:2]))
            sock.listen(_BACKLOG)
            return sock
    except OSError:
        pass  # somebody else has the name
    sock.close()
    return None


def _make() -> socket.socket | None:
    """A Unix socket; None where there is no such thing, or no file left, which TCP will tell."""
    if sys.platform != "linux":
        return None
    try:
        return socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError:
        return None


def widen(sock: socket.socket) -> bool:
    """Let a sender be far ahead of its receiver; False when the system does not."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _AHEAD)
    return sock.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) >= _AHEAD


def name_of(address: object) -> str | None:
    """ "host:port" behind the address of a local socket; None for what is none."""
    return address.decode().removeprefix(_PREFIX) if isinstance(address, bytes) and address else None


def connect_locally(address: str, port: int) -> socket.socket | None:
    """A connected, blocking socket to a port of this computer; None when that is to be reached by TCP only.

    It answers at once. A listener of another user is not trusted: anybody can take any name.
    """
    sock = _make()
    if sock is None or sys.platform != "linux":  # the second is for who checks types elsewhere
        return None
    try:
        sock.setblocking(False)  # a full queue would be waited for
        sock.connect(_PREFIX + format_address(address, port))
        credentials = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
        if _CREDENTIALS.unpack(credentials)[1] in (os.geteuid(), 0):
            sock.setblocking(True)
            return _LocalSocket(fileno=sock.detach())
    except OSError:
        pass  # nobody has that name
    sock.close()
    return None


class _LocalSocket(socket.socket):
    """Does not hand out what its sender has called void, nor anything after its own end."""

    _read_at = 0.0
    _ended = False

    def shutdown(self, how: int) -> None:
        # What waits could still be read, and the sender would look as if it had closed the connection.
        self._ended = self._ended or how != socket.SHUT_WR
        super().shutdown(how)

    def recv_into(self, *arguments: Any) -> int:
        count = super().recv_into(*arguments)
        if self._ended:
            return 0
        now = monotonic()
        if now - self._read_at > _PAUSE and count and self._read_at and _is_void(self):
            raise ConnectionLost(
                "what arrived while this program did not read is too old; its sender has called it void",
                peer="",
            )
        self._read_at = now
        return count


def make_void(sock: socket.socket) -> None:
    """Tell the receiver not to take what it has not read; the socket must stay open until it `has_left`."""
    try:
        sock.shutdown(socket.SHUT_RD)
    except OSError:
        pass  # it has left


def _is_void(sock: socket.socket) -> bool:
    """Whether the sender says so: it reads no more, and yet it has not closed the connection."""
    if sys.platform != "linux":
        return False
    try:
        sock.send(b"", socket.MSG_DONTWAIT)
        return False
    except BrokenPipeError:
        return not _poll(sock) & select.POLLRDHUP
    except OSError:
        return False


def has_left(sock: socket.socket) -> bool:
    """Whether the receiver has closed its end."""
    if sys.platform != "linux":
        return True
    return bool(_poll(sock) & (select.POLLHUP | select.POLLERR | select.POLLNVAL))


def _poll(sock: socket.socket) -> int:
    if sys.platform != "linux":
        return 0
    poll = select.poll()
    poll.register(sock, select.POLLRDHUP)
    return next((events for _, events in poll.poll(0)), 0)
