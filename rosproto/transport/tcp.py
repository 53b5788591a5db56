"""TCP sockets: connecting with one deadline, listening on one address, and the options for robots."""

from __future__ import annotations

import errno
import socket
import sys

from rosproto.errors import ConnectionLost, RosError
from rosproto.transport.address import format_address, resolve
from rosproto.transport.deadline import Deadline
from rosproto.transport.os_errors import translate

__all__ = [
    "KEEPALIVE_COUNT",
    "KEEPALIVE_IDLE",
    "KEEPALIVE_INTERVAL",
    "connect",
    "interrupt",
    "listen",
    "tune",
]

# A peer that vanished (power, Wi-Fi) is noticed after idle + count * interval = 30 s; the system's own
# defaults are two hours, and a quarter of an hour when data is on its way.
KEEPALIVE_IDLE = 10
KEEPALIVE_INTERVAL = 5
KEEPALIVE_COUNT = 4
_USER_TIMEOUT_MS = 1000 * (KEEPALIVE_IDLE + KEEPALIVE_COUNT * KEEPALIVE_INTERVAL)


def connect(host: str, port: int, deadline: Deadline) -> socket.socket:
    """A connected, tuned, blocking socket. Every address of the host is tried within one deadline.

    Raises:
        ConnectionLost: Refused, no route, or the name is unknown; the text names the address.
        RosTimeout: The deadline passed.
    """
    if not 0 < port <= 65535:
        raise ConnectionLost(f"connect to {host!r}: port {port} is none", peer=format_address(host, port))
    addresses = resolve(host, deadline)
    problem: RosError | None = None
    for number, address in enumerate(addresses):
        left = deadline.remaining()
        # an address that does not answer must leave time for those after it
        share = left if left is None else left / (len(addresses) - number)
        try:
            return _connect(address, port, share)
        except OSError as error:
            peer = format_address(address, port)
            named = peer if address == host else f"{peer} ({host})"
            # the first address is the one people mean; ::1 of localhost is an afterthought
            if problem is None:
                problem = translate(error, f"connect to {named}", peer, deadline)
                problem.__cause__ = error
    assert problem is not None
    raise problem


def _connect(address: str, port: int, seconds: float | None) -> socket.socket:
    if seconds is not None and seconds <= 0:
        raise TimeoutError
    sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
    try:
        sock.settimeout(seconds)
        sock.connect((address, port))
        if sock.getsockname() == sock.getpeername():
            # A connect to a free port of the ephemeral range can meet itself ("simultaneous open"): a node
            # retrying a dead peer on its own machine would then talk to itself and block the port.
            raise OSError(errno.ECONNREFUSED, "connected to itself")
        sock.settimeout(None)
        tune(sock)
    except BaseException:
        sock.close()
        raise
    return sock


def listen(host: str, port: int = 0, backlog: int = 1024) -> socket.socket:
    """A listening socket on exactly this address; port 0 takes a free one (ask `getsockname`).

    The backlog is long (systems cut it to what they allow): whoever finds it full in a flood of connections
    is not refused but waits a whole second for TCP to ask again.

    "0.0.0.0" and "::" listen on every interface: only when the caller says so.

    Raises:
        ConnectionLost: The port is taken, or the address is not this computer's.
    """
    peer = format_address(host, port)
    if not host:
        raise ValueError(
            "listen: host is empty; say 127.0.0.1, an address of this computer, or 0.0.0.0 for all"
        )
    address = resolve(host)[0]
    sock = socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM)
    try:
        _set_reuse(sock)
        sock.bind((address, port))
        sock.listen(backlog)
    except (OSError, OverflowError) as error:
        sock.close()
        if isinstance(error, OverflowError):
            raise ConnectionLost(f"listen on {peer}: port {port} is none", peer=peer) from error
        raise translate(error, f"listen on {peer}", peer) from error
    return sock


def _set_reuse(sock: socket.socket) -> None:
    """A restarted master must get its port back at once, and nobody may share a port with it.

    Windows' SO_REUSEADDR would let another program take over a port in use.
    """
    exclusive = getattr(socket, "SO_EXCLUSIVEADDRUSE", None)
    if exclusive is not None:
        sock.setsockopt(socket.SOL_SOCKET, exclusive, 1)
    elif sys.platform != "win32":
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


def tune(sock: socket.socket, nodelay: bool = True) -> None:
    """Set the options of a TCPROS or XML-RPC connection: no Nagle delay, dead peers noticed in 30 s.

    TCP_USER_TIMEOUT (Linux) also ends a connection whose peer has not read for 30 s although it lives;
    it reconnects when it does.
    """
    if nodelay:
        _try_option(sock, socket.IPPROTO_TCP, "TCP_NODELAY", 1)
    _try_option(sock, socket.SOL_SOCKET, "SO_KEEPALIVE", 1)
    if sys.platform == "win32":
        _tune_windows(sock)
        return
    # macOS calls TCP_KEEPIDLE by another name
    idle = "TCP_KEEPIDLE" if hasattr(socket, "TCP_KEEPIDLE") else "TCP_KEEPALIVE"
    _try_option(sock, socket.IPPROTO_TCP, idle, KEEPALIVE_IDLE)
    _try_option(sock, socket.IPPROTO_TCP, "TCP_KEEPINTVL", KEEPALIVE_INTERVAL)
    _try_option(sock, socket.IPPROTO_TCP, "TCP_KEEPCNT", KEEPALIVE_COUNT)
    _try_option(sock, socket.IPPROTO_TCP, "TCP_USER_TIMEOUT", _USER_TIMEOUT_MS)


def interrupt(sock: socket.socket) -> None:
    """End a connection in both directions and wake the threads that read or write it; from any thread.

    The owner still closes the socket. On POSIX it is only shut down here, because closing would let a new
    socket take its number while another thread still reads. On Windows a read that waits ends only when
    its socket is closed.
    """
    try:
        sock.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass  # the peer was faster
    if sys.platform == "win32":
        sock.close()


def _try_option(sock: socket.socket, level: int, name: str, value: int) -> None:
    option = getattr(socket, name, None)
    if option is None:
        return
    try:
        sock.setsockopt(level, option, value)
    except OSError:
        pass  # a comfort, not a need: socket pairs and odd systems lack some; macOS refuses on closed peers


def _tune_windows(sock: socket.socket) -> None:
    control, values = getattr(sock, "ioctl", None), getattr(socket, "SIO_KEEPALIVE_VALS", None)
    if control is None or values is None:
        return
    try:
        control(values, (1, 1000 * KEEPALIVE_IDLE, 1000 * KEEPALIVE_INTERVAL))
    except OSError:
        pass  # as above
