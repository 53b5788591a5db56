"""How long a send or receive may wait, kept by the kernel.

`socket.settimeout` makes Python poll before every call, which is two system calls more per service call on
each side. SO_RCVTIMEO and SO_SNDTIMEO do the same without; Windows keeps `settimeout`, and so do the sockets
that gevent puts in the place of Python's, which never wait in the kernel.
"""

from __future__ import annotations

import _socket
import socket
import struct
import sys

_TIMEVAL = struct.Struct("@ll")  # seconds, microseconds; macOS pads its shorter microseconds to the same
_KERNEL = sys.platform in ("linux", "darwin") and _TIMEVAL.size == 16


def limit_waits(sock: socket.socket, seconds: float | None) -> None:
    """Let every later send or receive that waits this long fail; None lets it wait for ever.

    It fails with BlockingIOError or TimeoutError. Do not mix with `settimeout` on the same socket.
    """
    if not (_KERNEL and isinstance(sock, _socket.socket)):
        sock.settimeout(seconds)
        return
    whole = 0.0 if seconds is None else max(seconds, 1e-5)  # zero means for ever there
    value = _TIMEVAL.pack(int(whole), int(whole % 1 * 1e6))
    sock.setblocking(True)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, value)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, value)
