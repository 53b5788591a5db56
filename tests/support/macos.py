"""Simulates macOS on Linux: its set of names, and the differences of its sockets.

Call `become_macos()` before importing our packages. From XNU's sources (bsd/kern/uipc_syscalls.c, uipc_socket.c,
bsd/netinet/tcp_usrreq.c) and reports of others who met them:

* `accept` gives a connection that was reset meanwhile without an address (Python: None).
* `setsockopt`, `getpeername` fail with EINVAL, `shutdown` with ENOTCONN, `send` with EPROTOTYPE or EPIPE, once the other
  side has ended the connection.
* TCP_KEEPALIVE is what Linux calls TCP_KEEPIDLE; there is no TCP_USER_TIMEOUT.
* Terminals start programs with 256 files; the buffers of a socket are small.
* There is no epoll. (kqueue cannot be imitated: `selectors` takes poll then, as where kqueue is missing.)
"""

from __future__ import annotations

import errno
import os
import resource
import select
import selectors
import signal
import socket
import struct
import sys
import time
from typing import Any

__all__ = ["MacSocket", "become_macos"]

ABSENT = {
    select: "epoll EPOLLIN EPOLLOUT EPOLLERR EPOLLHUP EPOLLET EPOLLRDHUP",
    selectors: "EpollSelector",
    socket: "TCP_KEEPIDLE TCP_USER_TIMEOUT TCP_CORK TCP_QUICKACK TCP_DEFER_ACCEPT TCP_INFO TCP_CONGESTION TCP_SYNCNT"
    " MSG_NOSIGNAL MSG_MORE MSG_ERRQUEUE MSG_CMSG_CLOEXEC SO_BINDTODEVICE SO_PEERCRED SO_PRIORITY SO_MARK SO_DOMAIN"
    " SO_PROTOCOL SOCK_CLOEXEC SOCK_NONBLOCK AF_NETLINK AF_PACKET AF_VSOCK AF_CAN",
    os: "sched_getaffinity sched_setaffinity eventfd memfd_create pidfd_open splice copy_file_range posix_fadvise"
    " posix_fallocate fdatasync getrandom pipe2 O_DIRECT O_TMPFILE",
    time: "CLOCK_BOOTTIME CLOCK_TAI pthread_getcpuclockid",
    signal: "sigwaitinfo sigtimedwait SIGPOLL SIGPWR SIGSTKFLT SIGRTMIN SIGRTMAX",
}
TCP_KEEPALIVE = 0x10  # macOS's number
BUFFER = 16 << 10  # bytes; of the size of what macOS gives a connection at first
FILES = 256
_LINUX_INFO, _LINUX_KEEPIDLE = 11, 4
_ENDED = (7, 8)  # TCP_CLOSE, TCP_CLOSE_WAIT
seen: dict[str, int] = {}
"""Counts of simulated macOS behaviour."""


def become_macos(files: int = FILES) -> None:
    """Make this process simulate macOS until it ends."""
    for module, names in ABSENT.items():
        for name in names.split():
            if hasattr(module, name):
                delattr(module, name)
    selectors.DefaultSelector = selectors.PollSelector  # type: ignore[misc,assignment]
    socket.TCP_KEEPALIVE = TCP_KEEPALIVE  # type: ignore[attr-defined]
    socket.socket = socket.SocketType = MacSocket  # type: ignore[misc]
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (files, hard))
    sys.platform = "darwin"


def _happened(what: str) -> None:
    seen[what] = seen.get(what, 0) + 1


class MacSocket(socket.socket):
    """A socket with macOS's behaviour."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        if self.type == socket.SOCK_STREAM:
            for option in (socket.SO_SNDBUF, socket.SO_RCVBUF):
                super().setsockopt(socket.SOL_SOCKET, option, BUFFER // 2)  # Linux doubles it

    @property
    def ended(self) -> bool:
        """The other side has ended the connection."""
        try:
            return self.getsockopt(socket.IPPROTO_TCP, _LINUX_INFO, 1)[0] == _ENDED[0]
        except OSError:
            return False

    def _refuse(self, what: str, number: int) -> None:
        _happened(what)
        raise OSError(number, os.strerror(number))

    def _accept(self) -> tuple[int, Any]:
        descriptor, address = super()._accept()  # type: ignore[misc]
        with socket.socket(fileno=os.dup(descriptor)) as other:
            gone = isinstance(other, MacSocket) and other.ended
        if gone:
            _happened("accept without address")
            return descriptor, None
        return descriptor, address

    def setsockopt(self, level: int, option: int, *value: Any) -> None:
        if self.ended and self._was_connected():
            self._refuse("setsockopt", errno.EINVAL)
        if level == socket.IPPROTO_TCP and option == TCP_KEEPALIVE:
            _happened("TCP_KEEPALIVE")
            option = _LINUX_KEEPIDLE
        super().setsockopt(level, option, *value)

    def _was_connected(self) -> bool:
        try:
            super().getpeername()
        except OSError:
            return super().getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) not in (0, errno.EINPROGRESS)
        return True

    def getpeername(self) -> Any:
        if self.ended:
            self._refuse("getpeername", errno.EINVAL)
        return super().getpeername()

    def shutdown(self, how: int) -> None:
        if self.ended:
            self._refuse("shutdown", errno.ENOTCONN)
        super().shutdown(how)

    def send(self, *arguments: Any) -> int:
        if self.ended:
            self._refuse("send", errno.EPROTOTYPE)
        return super().send(*arguments)

    def sendall(self, *arguments: Any) -> None:
        if self.ended:
            self._refuse("send", errno.EPROTOTYPE)
        super().sendall(*arguments)

    def sendmsg(self, *arguments: Any) -> int:
        if self.ended:
            self._refuse("send", errno.EPROTOTYPE)
        return super().sendmsg(*arguments)


def reset(sock: socket.socket) -> None:
    """Close with RST."""
    socket.socket.setsockopt(sock, socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    sock.close()
