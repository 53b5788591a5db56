"""A port behind the door is closed once its one client is connected: nobody else reaches the SDK's server.

The SDK listens as long as its server runs. On Linux a program can end that for a socket of its own
(`shutdown` of what listens; the SDK's loop ends with it, connections stay), and the kernel's table of
connections tells who came before. Elsewhere neither is to be had, and `sealed` says so.
"""

from __future__ import annotations

import os
import socket
import sys
from pathlib import Path

from rosproto.records import NamedTuple

__all__ = ["Intruded", "sealed"]

_PROC: Path | None = Path("/proc/self") if sys.platform == "linux" else None
_LISTENING, _READS = "0A", ("01", "08")  # established; closed by the other side, which may still read


class Intruded(Exception):
    """Somebody else has connected to a port that was meant for one client."""


class _Row(NamedTuple):
    """One socket of the kernel's table."""

    local: str
    remote_port: int
    state: str
    inode: str


def sealed(port: int, client: int) -> bool:
    """Close a listening port of this process; True when that can be done here, False where it cannot.

    Args:
        port: On 127.0.0.1.
        client: The port that its one client has.

    Raises:
        Intruded: Another client was there before.
    """
    if _PROC is None:
        return False
    try:
        listener = next((row for row in _rows(_PROC, port) if row.state == _LISTENING), None)
        if listener is None or not _end_listening(_PROC, listener.inode):
            return False
        others = _strangers(_PROC, port, client)
    except OSError:  # no /proc here
        return False
    if others:
        raise Intruded(f"port {port} had other clients than the viewer, from port {others[0]}")
    return True


def _strangers(proc: Path, port: int, client: int) -> list[int]:
    """Ports of those who are connected to a port of this computer, but one."""
    return [row.remote_port for row in _rows(proc, port) if row.state in _READS and row.remote_port != client]


def _rows(proc: Path, port: int) -> list[_Row]:
    """Sockets of 127.0.0.1 with that port."""
    ours = f"{int.from_bytes(socket.inet_aton('127.0.0.1'), sys.byteorder):08X}:{port:04X}"
    found = []
    for line in (proc / "net" / "tcp").read_text("ascii").splitlines()[1:]:
        words = line.split()
        if len(words) > 9 and words[1] == ours:
            found.append(_Row(ours, int(words[2].partition(":")[2], 16), words[3], words[9]))
    return found


def _end_listening(proc: Path, inode: str) -> bool:
    """Whether this process has that socket; if so, it listens no more."""
    wanted = f"socket:[{inode}]"
    for entry in os.listdir(proc / "fd"):
        try:
            if os.readlink(proc / "fd" / entry) != wanted:
                continue
            with socket.socket(fileno=os.dup(int(entry))) as listener:
                listener.shutdown(socket.SHUT_RDWR)  # of the socket, not of this number for it
            return True
        except OSError:  # closed meanwhile, or the listing itself
            continue
    return False
