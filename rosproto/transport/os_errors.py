"""Translate the operating system's errors into ours, with advice; and the limit on open files.

The limit counts sockets as well: terminals on macOS start programs with 256, Linux usually with 1024. Windows
has no such limit for sockets.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.sentence import both, led, say
from rosproto.transport.deadline import Deadline

if sys.platform != "win32":  # with this module: later, no file may be left to read it from
    import resource

_REFUSED = {errno.ECONNREFUSED, 10061}  # 100xx: Windows' own numbers
_UNREACHABLE = {errno.ENETUNREACH, errno.EHOSTUNREACH, errno.ENETDOWN, 10051, 10065, 10050}
_UNREACHABLE |= {getattr(errno, "EHOSTDOWN", 10064), 10064}  # macOS: no host has that address
_RESET = {errno.ECONNRESET, errno.EPIPE, errno.ECONNABORTED, errno.ENOTCONN, errno.EBADF, 10053, 10054, 10057}
_RESET |= {getattr(errno, name) for name in ("EPROTOTYPE", "ESHUTDOWN") if hasattr(errno, name)}  # macOS
_CLOSED_HERE = {10038, 10022, 10004}  # a read on Windows whose socket `tcp.interrupt` closed
_IN_USE = {errno.EADDRINUSE, errno.EACCES, 10048, 10013}
_NOT_OURS = {errno.EADDRNOTAVAIL, 10049}
_NO_FILE_LEFT = {errno.EMFILE, errno.ENFILE, 10024}


def translate(error: OSError, doing: str, peer: str, deadline: Deadline | None = None) -> RosError:
    """Our error for an OSError; raise it `from error`.

    Args:
        error: The system's error.
        doing: The operation, for the text: "connect to 10.0.0.7:11311".
        peer: The other side.
        deadline: The budget that a time-out used up.
    """
    # Python's own time-outs have no errno; with one, TCP itself gave up (keep-alive, TCP_USER_TIMEOUT)
    if isinstance(error, TimeoutError) and error.errno is None:
        seconds = None if deadline is None else deadline.seconds
        silent = (
            say("no answer") if seconds is None else say("no answer within {seconds:.3g} s", seconds=seconds)
        )
        why = both(silent, "check the address, the cable or Wi-Fi, and firewalls")
        return RosTimeout(led(doing, why), what=doing, seconds=seconds, peer=peer, why=why)
    reason = _reason(error)
    return ConnectionLost(led(doing, reason), peer=peer, why=reason)


@contextmanager
def system_errors(doing: str, peer: str = "") -> Iterator[None]:
    """Translate an OSError raised inside, with its cause chained; see `translate`.

    Raises:
        RosTimeout, ConnectionLost: In place of an OSError.
    """
    try:
        yield
    except RosError:
        raise
    except OSError as error:
        raise translate(error, doing, peer) from error


def _code(error: OSError) -> int | None:
    return getattr(error, "winerror", None) or error.errno


def connection_is_over(error: OSError) -> bool:
    """Whether the error only means that either side closed or reset the connection."""
    return _code(error) in _RESET | _CLOSED_HERE


def interpreter_shuts_down(error: BaseException) -> bool:
    """Whether a thread was refused because the interpreter shuts down (CPython 3.12)."""
    return isinstance(error, RuntimeError) and "interpreter shutdown" in str(error)


def is_out_of_files(error: OSError) -> bool:
    """Whether the process, or the computer, has reached its limit of open files and sockets."""
    return _code(error) in _NO_FILE_LEFT


def port_is_taken(error: object) -> bool:
    """Whether another program listens on the port, or this one is not permitted to."""
    return isinstance(error, OSError) and _code(error) in _IN_USE


def address_is_not_ours(error: object) -> bool:
    """Whether this computer does not have the address."""
    return isinstance(error, OSError) and _code(error) in _NOT_OURS


def no_route(error: object) -> bool:
    """Whether the network has no route at present: no address, or the cable is unplugged."""
    return isinstance(error, OSError) and _code(error) in _UNREACHABLE


def is_refused(error: BaseException) -> bool:
    """Whether this error, or a cause of it, says that nothing listens at the port."""
    cause: BaseException | None = error
    while cause is not None and not (isinstance(cause, OSError) and _code(cause) in _REFUSED):
        cause = cause.__cause__
    return cause is not None


def _reason(error: OSError) -> str:
    code = _code(error)
    if code in _REFUSED:
        return (
            "connection refused: nothing listens there; "
            "is the master (or node) running, and is the port right?"
        )
    if code in _UNREACHABLE:
        return "no route there; check this computer's network address, the cable or Wi-Fi, and any VPN"
    if code in _RESET:
        return "the connection was closed by the other side"
    if code in _CLOSED_HERE:
        return "the connection was closed on this side"
    if code in _IN_USE:
        return "the port is taken (or not allowed); another master or node holds it, use another port or 0"
    if code in _NOT_OURS:
        return "this computer has no such address; check ROS_HOSTNAME, ROS_IP or host="
    if code in _NO_FILE_LEFT:
        return both(_too_many_files(), "close some, or allow more with `ulimit -n 4096`")
    if isinstance(error, TimeoutError):
        return "the other side no longer answers; check its power, the cable or Wi-Fi, and firewalls"
    return error.strerror or str(error) or type(error).__name__


def _too_many_files() -> str:
    limit = open_file_limit()
    if limit is None:
        return say("too many open files in this program (or computer)")
    return say("too many open files in this program (or computer); the limit is {limit}", limit=limit)


def open_file_limit() -> int | None:
    """How many files this process may have open; None if there is no limit, or it is unknown."""
    if sys.platform != "win32":
        soft = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        return None if soft == resource.RLIM_INFINITY else soft
    return None


RESERVED_FILES = 64
"""Files that peers may not use up: a process needs some for links to its robot, and for a stop. At most a
quarter of all files is reserved."""
_MIN_CONNECTIONS = 8


def max_connections(newest: int, connections: Collection[int]) -> int:
    """How many connections a server may have open, so that `RESERVED_FILES` stay free.

    Args:
        newest: Descriptor of a connection that was just accepted. Systems give the lowest free number, so all
            lower ones are in use.
        connections: Descriptors of the open connections of this server.
    """
    limit = open_file_limit()
    if limit is None:
        return sys.maxsize
    others = newest - sum(each < newest for each in connections)
    return max(_MIN_CONNECTIONS, limit - min(RESERVED_FILES, limit // 4) - others)


def allow_open_files(count: int) -> None:
    """Raise the limit of open files to `count`, if it is lower and the system permits.

    For commands, which own their process, and for simulated robots, which run many nodes in one process.
    """
    if sys.platform != "win32":
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        unlimited = resource.RLIM_INFINITY
        if soft == unlimited or soft >= count:
            return
        wanted = count if hard == unlimited else min(count, hard)
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        except (OSError, ValueError):
            pass  # the limit stays; opening too many files raises an error that names it
