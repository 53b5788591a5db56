"""A port behind the door is closed once its one client is connected: nobody else reaches the SDK's server.

The SDK listens as long as its server runs. On Linux a program can end that for a socket of its own (by
`shutdown`: the SDK's loop ends with it, connections stay), and among its own open files are the connections
of all who came before. Elsewhere neither is to be had, and `sealed` says so.
"""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

__all__ = ["Intruded", "sealed"]

_FILES: Path | None = Path("/proc/self/fd") if sys.platform == "linux" else None


class Intruded(Exception):
    """Somebody else has connected to a port that was meant for one client."""


def sealed(port: int, client: int) -> bool:
    """Close a listening port of this process; True when that can be done here, False where it cannot.

    Args:
        port: On 127.0.0.1.
        client: The port that its one client has.

    Raises:
        Intruded: Another client was there before.
    """
    # With a default time-out, looking at a socket (`_sockets`) would set it to non-blocking for its owner.
    if _FILES is None or socket.getdefaulttimeout() is not None:
        return False
    try:
        if not _end_listening(_FILES, port):
            return False
        others = _strangers(_FILES, port, client)
    except OSError:  # no /proc here
        return False
    if others:
        raise Intruded(f"port {port} had other clients than the viewer, from port {others[0]}")
    return True


def _end_listening(files: Path, port: int) -> bool:
    """Whether a socket of this process listens there; if so, it does no more."""
    for one in _sockets(files, port):
        if one.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
            one.shutdown(socket.SHUT_RDWR)  # of the socket, not of this number for it
            return True
    return False


def _strangers(files: Path, port: int, client: int) -> list[int]:
    """Ports of those whose connection was taken there, but one."""
    found = []
    for one in _sockets(files, port):
        try:
            peer = int(one.getpeername()[1])
        except OSError:  # it has gone
            continue
        if peer != client:
            found.append(peer)
    return found


def _sockets(files: Path, port: int) -> Iterator[socket.socket]:
    """The open sockets of this process that have this port of 127.0.0.1; each is there until the next."""
    for entry in os.listdir(files):
        try:
            if not os.readlink(files / entry).startswith("socket:"):
                continue
            one = socket.socket(fileno=os.dup(int(entry)))
        except OSError:  # closed meanwhile, or the listing itself
            continue
        with one:
            try:
                ours = one.family == socket.AF_INET and one.getsockname() == ("127.0.0.1", port)
            except OSError:
                continue
            if ours:
                yield one
