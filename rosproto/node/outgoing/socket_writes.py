"""Writing several pieces to a socket that does not block, in as few system calls as the system has for it."""

from __future__ import annotations

import socket
import sys
from collections.abc import Sequence

from rosproto.node.outgoing.frames import remaining

MOST_VIEWS = 64  # buffers for one sendmsg; IOV_MAX is 1024 on Linux, 16 at the least by POSIX


def send_some(sock: socket.socket, views: Sequence[bytes | memoryview]) -> tuple[int, OSError | None]:
    """Send as much as the socket takes now: (bytes sent, error)."""
    total = 0
    try:
        if sys.platform != "win32":  # where there is no sendmsg
            rest: Sequence[bytes | memoryview] = views
            while rest:
                some = rest[:MOST_VIEWS]
                sent = sock.sendmsg(some)
                total += sent
                if sent < sum(map(len, some)):
                    # A signal or the buffer's end; either way the next try tells.
                    rest = [*remaining([memoryview(v) for v in some], sent), *rest[MOST_VIEWS:]]
                    continue
                rest = rest[MOST_VIEWS:]
            return total, None
        for view in views:
            view = memoryview(view)
            while view:
                sent = sock.send(view)
                total += sent
                view = view[sent:]
    except BlockingIOError:
        pass
    except OSError as error:
        return total, error
    return total, None
