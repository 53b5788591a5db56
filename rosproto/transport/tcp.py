"""TCP connections: listen on one address, options for robots, connect, and exchange connection headers.

Connecting and the header have one deadline (in rospy the connect time-out does not cover the handshake, which
can hang for ever); the socket is blocking again when a function with a deadline returns.

A network may be unreachable for a moment. The system repeats a lost connection request after one second, then
two, then four. Waiting for that would notice a restored network seconds late, and giving up early would never
succeed on a slow one. So `connect` lets an attempt without a reply continue while it starts further ones; the
first to succeed is used.
"""

from __future__ import annotations

import errno
import os
import selectors
import socket
import struct
import sys
import time
from collections.abc import Mapping

from rosproto.errors import ConnectionLost, TooLarge
from rosproto.protocol.handshake import decode_header, encode_header
from rosproto.protocol.wire_limits import Limits
from rosproto.sentence import both, led, say
from rosproto.transport.deadline import Deadline
from rosproto.transport.forking import close_in_forked_children
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import system_errors, translate
from rosproto.transport.robot_host_names import HostNames
from rosproto.transport.uri import format_address

# A peer that vanished (power, Wi-Fi) is noticed after idle + count * interval = 30 s; the system's own
# defaults are two hours, and a quarter of an hour while data is unacknowledged. Links to subscribers are
# watched more closely (rosproto/node/outgoing/link_monitor.py).
KEEPALIVE_IDLE = 10
KEEPALIVE_INTERVAL = 5
KEEPALIVE_COUNT = 4

# Where we only receive and reconnect by ourselves: 5 s. A shorter silence is left to TCP.
SILENCE_IDLE = 2
SILENCE_INTERVAL = 1
SILENCE_COUNT = 3

# Unacknowledged data is sent again after growing pauses of up to two minutes: after an outage of half a
# minute nothing would arrive for another half. One second is the smallest value.
_RTO_MAX_MS = 1000
_WINDOWS_PROBES = 10  # fixed on Windows

# Options for which Python has no name: of linux/tcp.h, since Linux 6.15; of ws2ipdef.h and macOS's
# netinet/tcp.h, seconds for which unacknowledged data is repeated before the connection is given up.
_UNNAMED = {
    "linux": {"TCP_RTO_MAX_MS": 44},
    "win32": {"TCP_MAXRT": 5},
    "darwin": {"TCP_RXT_CONNDROPTIME": 0x80},
}

_BACKLOG = 1024
"""Systems cut it to what they allow. A client that finds it full is not refused but waits a whole second."""


def listen(host: str, port: int = 0, *, only_ipv6: bool = False) -> socket.socket:
    """Return a listening socket on exactly this address; port 0 takes a free one (ask `getsockname`).

    "0.0.0.0" and "::" listen on every interface: only when the caller asks for that. With `only_ipv6`, "::"
    leaves IPv4 out on every system, as Windows does anyway.

    Raises:
        ConnectionLost: The port is taken, or the address is not this computer's.
    """
    peer = format_address(host, port)
    if not host:
        raise ValueError(
            "listen: host is empty; give 127.0.0.1, an address of this computer, or 0.0.0.0 for all"
        )
    address = resolve(host)[0]
    with system_errors(f"listen on {peer}", peer):
        sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
    try:
        reuse_address(sock)
        if only_ipv6 and sock.family == socket.AF_INET6:
            sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        sock.bind((address, port))
        sock.listen(_BACKLOG)
    except (OSError, OverflowError) as error:
        sock.close()
        if isinstance(error, OverflowError):
            text = say(
                "listen on {address}: {port} is not a port; expected 0 to 65535", address=peer, port=port
            )
            raise ConnectionLost(text, peer=peer) from error
        raise translate(error, say("listen on {peer}", peer=peer), peer) from error
    return sock


def bind_beside(sock: socket.socket, listener: socket.socket, address: tuple[str, int]) -> None:
    """Bind a socket that will connect to the address that another one listens on.

    Linux allows it if both sockets share their port. The listener does so for this moment; afterwards only
    programs of the same user that ask for it can share the port.

    Raises:
        OSError: The system does not allow it, or the address is no longer this computer's.
    """
    if sys.platform != "linux":
        raise OSError("this system does not allow binding to a port that another socket listens on")
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
    try:
        sock.bind(address)
    finally:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 0)


def reuse_address(sock: socket.socket) -> None:
    """Before `bind`: let a restarted server have its port back at once, without sharing the port.

    On Windows, SO_REUSEADDR would let another program take over a port in use, and without
    SO_EXCLUSIVEADDRUSE another socket could listen on 0.0.0.0 beside one on 127.0.0.1.
    """
    exclusive = getattr(socket, "SO_EXCLUSIVEADDRUSE", None)
    if exclusive is not None:
        sock.setsockopt(socket.SOL_SOCKET, exclusive, 1)
    elif sys.platform != "win32":
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


def tune(sock: socket.socket) -> None:
    """Set the options of a TCPROS or XML-RPC connection: no Nagle delay, dead peers noticed in 30 s.

    TCP_USER_TIMEOUT (Linux) also ends a connection whose peer is alive but has not read for 30 s; the peer
    reconnects when it reads again. From Linux 6.15 on, lost data is repeated every second.
    """
    _set_options(sock, TCP_NODELAY=1, TCP_RTO_MAX_MS=_RTO_MAX_MS)
    _probe(sock, KEEPALIVE_IDLE, KEEPALIVE_INTERVAL, KEEPALIVE_COUNT)


def expect_data(sock: socket.socket) -> None:
    """End a connection on which we only receive after 5 s without a sign of life (`SILENCE_IDLE`).

    The peer's system sends these signs, also while its program sends nothing or is stopped.
    """
    _probe(sock, SILENCE_IDLE, SILENCE_INTERVAL, SILENCE_COUNT)


def expect_acknowledgement(sock: socket.socket, seconds: int) -> bool:
    """Have the system end a connection when the peer has not acknowledged data for that long.

    For Windows and macOS; on Linux the owner of the connection decides with `unsent_bytes.py`. The peer's
    system acknowledges by itself, also while its program is slow or stopped.

    Returns:
        Whether the system supports it.
    """
    return _set_options(sock, TCP_MAXRT=seconds, TCP_RXT_CONNDROPTIME=seconds)


def allow_repair(sock: socket.socket, seconds: float) -> None:
    """Have Linux give a connection up this many seconds later than `tune` says.

    For a connection on which the system has been sending lost data again for that long. Linux counts
    TCP_USER_TIMEOUT from the first of these repetitions, and begins anew only when nothing is lost any more.
    On a network that loses 5 % it would end a connection that carries data all the time (after 30 to 40 s at
    a round trip of 0.6 s and 20 messages a second, measured).
    """
    limit = KEEPALIVE_IDLE + KEEPALIVE_INTERVAL * KEEPALIVE_COUNT + seconds
    _set_options(sock, TCP_USER_TIMEOUT=round(1000 * limit))


def set_linger(sock: socket.socket, linger: bool) -> None:
    """Choose whether unsent data is still delivered after the socket is closed or the program killed.

    False discards it and resets the connection (SO_LINGER of 0 s).
    """
    value = struct.pack("hh" if sys.platform == "win32" else "ii", not linger, 0)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, value)
    except OSError:
        pass  # closed by the peer already


def _probe(sock: socket.socket, idle: int, interval: int, count: int) -> None:
    """Have the system probe the peer after `idle` seconds, `count` times (keep-alive)."""
    if sys.platform == "win32":
        _set_options(sock, SO_KEEPALIVE=1)
        _probe_windows(sock, idle, interval * count / _WINDOWS_PROBES)
        return
    _set_options(
        sock,
        SO_KEEPALIVE=1,
        TCP_KEEPIDLE=idle,
        TCP_KEEPALIVE=idle,  # macOS's name for it
        TCP_KEEPINTVL=interval,
        TCP_KEEPCNT=count,
        # Linux uses this instead of the count when both are set.
        TCP_USER_TIMEOUT=1000 * (idle + interval * count),
    )


def interrupt(sock: socket.socket, *, deliver: bool = True) -> None:
    """End a connection in both directions and wake the threads that read or write it; from any thread.

    What was not sent yet is discarded with `deliver=False`.

    The owner still closes the socket. On POSIX it is only shut down here: closing would let a new socket
    reuse its number while another thread still reads. On Windows a waiting read ends only when its socket is
    closed.
    """
    if not deliver:
        set_linger(sock, False)
    try:
        sock.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass  # the peer closed first
    if sys.platform == "win32":
        sock.close()


def _set_options(sock: socket.socket, **options: int) -> bool:
    """Set options, given by name, where the system has them; True if at least one was set.

    A failure is ignored: socket pairs and odd systems lack some, and macOS refuses them on closed peers.
    """
    unnamed = _UNNAMED.get(sys.platform, {})
    some = False
    for name, value in options.items():
        option = getattr(socket, name, None) or unnamed.get(name)
        if option is not None:
            level = socket.SOL_SOCKET if name.startswith("SO_") else socket.IPPROTO_TCP
            try:
                sock.setsockopt(level, option, value)
                some = True
            except OSError:
                pass
    return some


def _probe_windows(sock: socket.socket, idle: float, interval: float) -> None:
    control, values = getattr(sock, "ioctl", None), getattr(socket, "SIO_KEEPALIVE_VALS", None)
    if control is None or values is None:
        return
    try:
        control(values, (1, int(1000 * idle), int(1000 * interval)))
    except OSError:
        pass  # as above


def open_selector(doing: str) -> selectors.BaseSelector:
    """The system's best selector.

    Raises:
        ConnectionLost: No file is left to open.
    """
    with system_errors(doing):
        return selectors.DefaultSelector()


def wake_pair(doing: str) -> tuple[socket.socket, socket.socket]:
    """Two connected sockets: one to wait for, and one to write to.

    Raises:
        ConnectionLost: No file is left to open.
    """
    with system_errors(doing):
        return socket.socketpair()


# -- connecting ----------------------------------------------------------------------------------------------

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


# -- connection headers and whole buffers --------------------------------------------------------------------

_PIECE = 64 << 10  # bytes; memory grows with what has arrived, not with the announced length


class ClosedBeforeHeader(ConnectionLost):
    """The peer connected and closed without sending a byte, as port probes do; not a failure."""


def peer_name(sock: socket.socket) -> str:
    """ "host:port" of the other side, or "peer" if it has gone."""
    try:
        return format_address(*sock.getpeername()[:2])
    except (OSError, TypeError):
        return "peer"


def write_all(sock: socket.socket, data: bytes | bytearray | memoryview, deadline: Deadline) -> None:
    """Write all bytes.

    Raises:
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not accept them before the deadline.
    """
    try:
        sock.settimeout(deadline.for_socket())
        sock.sendall(data)  # its time-out covers the whole call
        sock.settimeout(None)
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, say("write to {peer}", peer=peer), peer, deadline) from error


def write_steadily(sock: socket.socket, data: bytes) -> None:
    """Write all bytes, however long it takes: the socket's time-out limits only the wait for the next piece.

    Raises:
        ConnectionLost: The peer closed.
        RosTimeout: The peer accepted nothing within the time-out.
    """
    try:
        sent = sock.send(data)
        while sent < len(data):
            sent += sock.send(memoryview(data)[sent:])
    except OSError as error:
        peer = peer_name(sock)
        raise translate(error, say("write to {peer}", peer=peer), peer) from error


def read_header(sock: socket.socket, limits: Limits, deadline: Deadline) -> dict[str, str]:
    """Read one connection header and nothing after it, so that messages stay in the socket.

    Raises:
        ClosedBeforeHeader: The peer closed without a byte.
        ConnectionLost: The peer closed in the middle.
        RosTimeout: The deadline passed.
        TooLarge: `Limits.header_bytes`.
        RemoteProtocolError: The bytes are not a header.
    """
    (size,) = struct.unpack("<I", _read(sock, 4, 0, deadline))
    if size > limits.header_bytes:
        raise TooLarge("header_bytes", size, limits.header_bytes)
    return decode_header(_read(sock, size, 4, deadline))


def _read(sock: socket.socket, size: int, before: int, deadline: Deadline) -> bytearray:
    """Read `size` bytes of a header, of which `before` bytes were read already."""
    data = bytearray()
    try:
        while len(data) < size:
            sock.settimeout(deadline.for_socket())
            piece = sock.recv(min(size - len(data), _PIECE))
            if not piece:
                break
            data += piece
        sock.settimeout(None)
    except OSError as error:
        peer = peer_name(sock)
        doing = say("read a connection header from {address}", address=peer)
        raise translate(error, doing, peer, deadline) from error
    if len(data) < size:
        have = before + len(data)
        doing = say("read a connection header, after {count} bytes", count=have)
        text = led(doing, "the connection was closed by the other side")
        raise (ConnectionLost if have else ClosedBeforeHeader)(text, peer=peer_name(sock))
    return data


def write_header(sock: socket.socket, fields: Mapping[str, str], deadline: Deadline) -> None:
    """Write one connection header.

    Raises:
        LocalProtocolError: A field cannot be encoded.
        ConnectionLost: The peer closed.
        RosTimeout: The peer did not accept it before the deadline.
    """
    write_all(sock, encode_header(fields), deadline)
