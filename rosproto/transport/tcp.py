"""TCP sockets: listen on one address, and set the options for robots. (To connect: connecting.py.)"""

from __future__ import annotations

import selectors
import socket
import struct
import sys

from rosproto.errors import ConnectionLost
from rosproto.transport.name_lookup import resolve
from rosproto.transport.os_errors import system_errors, translate
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
            "listen: host is empty; say 127.0.0.1, an address of this computer, or 0.0.0.0 for all"
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
            raise ConnectionLost(
                f"listen on {peer}: {port} is not a port; expected 0 to 65535", peer=peer
            ) from error
        raise translate(error, f"listen on {peer}", peer) from error
    return sock


def bind_beside(sock: socket.socket, listener: socket.socket, address: tuple[str, int]) -> None:
    """Bind a socket that will connect to the address that another one listens on.

    Linux allows it if both sockets share their port. The listener does so for this moment; afterwards only
    programs of the same user that ask for it can share the port.

    Raises:
        OSError: The system does not allow it, or the address is no longer this computer's.
    """
    if sys.platform != "linux":
        raise OSError("this system does not bind beside a listening socket")
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


def interrupt(sock: socket.socket) -> None:
    """End a connection in both directions and wake the threads that read or write it; from any thread.

    The owner still closes the socket. On POSIX it is only shut down here: closing would let a new socket
    reuse its number while another thread still reads. On Windows a waiting read ends only when its socket is
    closed.
    """
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
