"""What a thread that waits for sockets needs: a selector, and a pair of sockets to wake it by.

Both take open files, of which a process has so many: here their absence becomes our error.
"""

from __future__ import annotations

import selectors
import socket

from rosproto.transport.os_errors import system_errors


def open_selector(doing: str) -> selectors.BaseSelector:
    """The system's best selector.

    Raises:
        ConnectionLost: No file is left to open.
    """
    with system_errors(doing):
        return selectors.DefaultSelector()


def wake_pair(doing: str) -> tuple[socket.socket, socket.socket]:
    """Two sockets joined to each other: the one to wait for, and the one to write to.

    Raises:
        ConnectionLost: No file is left to open.
    """
    with system_errors(doing):
        return socket.socketpair()
