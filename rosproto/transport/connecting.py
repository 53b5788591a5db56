"""Connect within one deadline, over a network that may be unreachable for a moment.

The system repeats a lost connection request after one second, then two, then four. Waiting for that would
notice a restored network seconds late, and giving up early would never succeed on a slow one. So an attempt
without a reply continues while further ones are started; the first to succeed is used.
"""

from __future__ import annotations

import errno
import os
import selectors
import socket
import time

from rosproto.errors import ConnectionLost
from rosproto.sentence import both, say
from rosproto.transport.deadline import Deadline
from rosproto.transport.forking import close_in_forked_children
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import translate
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.tcp import open_selector, tune
from rosproto.transport.uri import format_address

FIRST_ATTEMPT_SECONDS = 1.0  # before a second attempt: most slow networks answer faster
NEXT_ATTEMPT_SECONDS = 0.5  # between further attempts
MAX_PENDING = 8  # beyond it the oldest is closed; by then it has had four seconds

_IN_PROGRESS = {errno.EINPROGRESS, errno.EWOULDBLOCK, errno.EALREADY, 10035, 10036, 10037}  # 100xx: Windows


def connect(host: str, port: int, deadline: Deadline, *, hosts: HostNames | None = None) -> socket.socket:
    """Return a connected, tuned, blocking socket. Every address of the host is tried within one deadline.

    `hosts` resolves names that the system does not know.

    Raises:
        ConnectionLost: Refused, no route, or the name is unknown; the text names the address.
        RosTimeout: The deadline passed.
    """
    if not 0 < port <= 65535:
        raise ConnectionLost(
            say("connect to {host!r}: {port} is not a port; expected 1 to 65535", host=host, port=port),
            peer=format_address(host, port),
        )
    addresses = resolve(host, deadline) if hosts is None else hosts.resolve(host, deadline)
    attempts = _ConnectionAttempts(addresses, port, deadline)
    try:
        sock = attempts.run()
    finally:
        attempts.close()
    if sock is not None:
        sock.settimeout(None)
        return sock
    # report the first address: for localhost that is 127.0.0.1, not ::1
    address = addresses[0]
    problem = attempts.problems.get(address) or TimeoutError()
    peer = format_address(address, port)
    named = peer if address == host else f"{peer} ({host})"
    error = translate(problem, say("connect to {address}", address=named), peer, deadline)
    if hosts is not None and (why := hosts.why(host)):
        error.args = (both(str(error), why), *error.args[1:])
        error.why = both(error.why, why)
    raise error from problem


class _ConnectionAttempts:
    """Parallel attempts to connect to one of several addresses.

    Attributes:
        problems: Address -> why it is not tried any more.
    """

    def __init__(self, addresses: list[str], port: int, deadline: Deadline) -> None:
        self.problems: dict[str, OSError] = {}
        self._addresses = addresses
        self._port = port
        self._deadline = deadline
        self._begun = 0
        self._pending: dict[socket.socket, str] = {}
        self._selector: selectors.BaseSelector | None = None

    def run(self) -> socket.socket | None:
        """The first connected socket; None if every address has failed, or the deadline has passed."""
        while not self._deadline.expired and len(self.problems) < len(self._addresses):
            sock = self._begin() or self._wait(0.0 if self._begun == 1 else NEXT_ATTEMPT_SECONDS)
            if sock is not None:
                return sock
        return None

    def close(self) -> None:
        """Close the pending attempts."""
        for sock in self._pending:
            sock.close()
        if self._selector is not None:
            self._selector.close()

    def _begin(self) -> socket.socket | None:
        """Begin an attempt at the next address; return the socket if it connects at once."""
        left = [address for address in self._addresses if address not in self.problems]
        address = left[self._begun % len(left)]
        self._begun += 1
        try:
            sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
        except OSError as error:  # out of files, or an unsupported address family
            self._failed(address, error)
            return None
        close_in_forked_children(sock)
        try:
            tune(sock)  # before the first packet: the options decide how often it is repeated
            # Most succeed at once: those need no selector.
            sock.settimeout(self._at_most(FIRST_ATTEMPT_SECONDS) if self._begun == 1 else 0.0)
            sock.connect((address, self._port))
            return self._checked(sock)
        except OSError as error:
            if self._goes_on(error):
                self._watch(sock, address)
            else:
                sock.close()
                self._failed(address, error)
            return None
        except BaseException:
            sock.close()
            raise

    @staticmethod
    def _goes_on(error: OSError) -> bool:
        """Whether the attempt continues although our wait has ended. A time-out with an errno is the
        system's: it has ended.
        """
        code = getattr(error, "winerror", None) or error.errno
        return code in _IN_PROGRESS or (isinstance(error, TimeoutError) and code is None)

    def _at_most(self, seconds: float) -> float:
        left = self._deadline.remaining()
        return seconds if left is None else min(seconds, left)

    def _watch(self, sock: socket.socket, address: str) -> None:
        sock.setblocking(False)
        self._pending[sock] = address
        if self._selector is None:
            self._selector = open_selector(say("connect to port {port}", port=self._port))
        self._selector.register(sock, selectors.EVENT_WRITE)
        if len(self._pending) > MAX_PENDING:
            self._drop(next(iter(self._pending)))

    def _wait(self, seconds: float) -> socket.socket | None:
        """Wait until a socket is connected, or until the next attempt is due."""
        end = time.monotonic() + seconds
        while self._pending and self._selector is not None:
            wait = self._at_most(end - time.monotonic())
            if wait <= 0:
                return None
            failed = len(self.problems)
            for key, _ in self._selector.select(wait):
                sock = key.fileobj
                assert isinstance(sock, socket.socket)
                if sock in self._pending and self._succeeded(sock):
                    return sock
            if len(self.problems) > failed:
                return None  # start the next address at once
        return None

    def _succeeded(self, sock: socket.socket) -> bool:
        assert self._selector is not None
        address = self._pending.pop(sock)
        self._selector.unregister(sock)
        code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        try:
            if code:
                raise OSError(code, os.strerror(code))
            self._checked(sock)
        except OSError as error:
            sock.close()
            self._failed(address, error)
            return False
        return True

    @staticmethod
    def _checked(sock: socket.socket) -> socket.socket:
        try:
            itself = sock.getsockname() == sock.getpeername()
        except OSError as error:  # macOS: EINVAL when the other side has closed at once
            raise OSError(errno.ECONNRESET, os.strerror(errno.ECONNRESET)) from error
        if itself:
            # A connect to a free ephemeral port can connect to itself ("simultaneous open"): a node retrying
            # a dead peer on its own computer would then talk to itself and block the port.
            raise OSError(errno.ECONNREFUSED, "connected to itself")
        return sock

    def _failed(self, address: str, error: OSError) -> None:
        self.problems[address] = error
        for sock in [sock for sock, other in self._pending.items() if other == address]:
            self._drop(sock)

    def _drop(self, sock: socket.socket) -> None:
        assert self._selector is not None
        del self._pending[sock]
        self._selector.unregister(sock)
        sock.close()
