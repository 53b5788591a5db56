"""The short way to a TCPROS port of the same computer: a socket of Linux's abstract kind, named after it.

TCP does for every message, also over loopback, what a network needs: segments, acknowledgements, timers. That
is a fifth to a quarter of the time from `publish()` to the callback. So whoever listens on a TCPROS port also
listens on a Unix socket that has the port's address as its name, and whoever connects to an address tries
that name first. Names belong to a network namespace, as addresses do: one that is there is the port meant.
The bytes are the same.

It is there only on Linux, and only where the system lets a sender be far ahead (4 MB, as newer ones do):
what a slow receiver has not taken waits there, as it would in TCP's buffers. Everybody else (rospy, roscpp,
another computer) uses the port.
"""

from __future__ import annotations

import os
import socket
import struct
import sys

from rosproto.transport.address import format_address

__all__ = ["connect_locally", "listen_locally", "name_of", "widen"]

_BACKLOG = 64
_PREFIX = "\0rosproto "  # the zero byte makes the name abstract: no file, gone with the socket
_AHEAD = 4 << 20  # bytes; net.core.wmem_max
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
            return sock
    except OSError:
        pass  # nobody has that name
    sock.close()
    return None
