"""Closes the port of an SDK server once its one client is connected, so that nobody else can reach it.

The SDK listens for as long as its server runs. On Linux a program can end that for any socket of its own:
`shutdown` ends the SDK's accept loop and leaves connections open. The connections accepted before that are
found among the process's open files. Other systems offer neither, and `close_listening_port` returns False.
"""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

__all__ = ["UnexpectedClient", "close_listening_port"]

_FILES: Path | None = Path("/proc/self/fd") if sys.platform == "linux" else None


class UnexpectedClient(Exception):
    """Another program has connected to a port that was meant for one client."""


def close_listening_port(port: int, client: int) -> bool:
    """Stop listening on a port of this process; True if it was done, False where the system cannot do it.

    Args:
        port: On 127.0.0.1.
        client: The port from which its one client has connected.

    Raises:
        UnexpectedClient: Another client connected first.
    """
    # With a default time-out, wrapping a descriptor (`_sockets`) makes it non-blocking for its owner, too.
    if _FILES is None or socket.getdefaulttimeout() is not None:
        return False
    try:
        if not _end_listening(_FILES, port):
            return False
        others = _other_clients(_FILES, port, client)
    except OSError:  # no /proc here
        return False
    if others:
        raise UnexpectedClient(f"port {port} had other clients than the viewer, from port {others[0]}")
    return True


def _end_listening(files: Path, port: int) -> bool:
    """Stop the socket of this process that listens there; False if there is none."""
    for one in _sockets(files, port):
        if one.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
            one.shutdown(socket.SHUT_RDWR)  # the socket itself, not only this descriptor
            return True
    return False


def _other_clients(files: Path, port: int, client: int) -> list[int]:
    """Ports of the clients whose connections were accepted there, except the expected one."""
    found = []
    for one in _sockets(files, port):
        try:
            peer = int(one.getpeername()[1])
        except OSError:  # it has hung up
            continue
        if peer != client:
            found.append(peer)
    return found


def _sockets(files: Path, port: int) -> Iterator[socket.socket]:
    """The open sockets of this process bound to this port of 127.0.0.1; each is valid until the next one."""
    for entry in os.listdir(files):
        try:
            if not os.readlink(files / entry).startswith("socket:"):
                continue
            one = socket.socket(fileno=os.dup(int(entry)))
        except OSError:  # closed meanwhile, or the directory being listed
            continue
        with one:
            try:
                ours = one.family == socket.AF_INET and one.getsockname() == ("127.0.0.1", port)
            except OSError:
                continue
            if ours:
                yield one
