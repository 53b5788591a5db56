"""Keeps a test process and the Pythons it starts from the user's own folders and other machines.

An audit hook checks each file that Python opens and each connection that it begins. Access to a guarded folder or to
another machine raises PermissionError. It is also written to a report file, because a program may swallow the error:
tests/conftest.py fails the test after which the report is not empty.

The deepest listed folder of a path decides: the home is guarded, a checkout or a Python inside it is free. Allowed are
addresses of the blocks for documentation, names that the domain system reserves (`.invalid`), and connecting a
datagram socket, which sends nothing.

Not covered: C code that opens files itself, programs other than Python, and Python with -I or -E. They get the same
environment, in which every variable for a folder of the user names a temporary one.

Uses the standard library only and imports little at start: tests check the imports of programs.
"""

from __future__ import annotations

import os
import sys
from _thread import _local

TYPE_CHECKING = False  # for type checkers; importing `typing` takes 15 ms per start
if TYPE_CHECKING:
    import ipaddress
    from typing import Any

__all__ = ["NETWORK", "VARIABLE", "explain", "install", "install_from_environment"]

VARIABLE = "TESTS_WATCH"  # JSON: the argument of `install`
NETWORK = "TESTS_WATCH_NETWORK"  # "own": this process has a separate, unconnected network

_PATHS = {
    "open": 1, "os.listdir": 1, "os.scandir": 1, "os.mkdir": 1, "os.remove": 1, "os.rmdir": 1, "os.truncate": 1,
    "os.rename": 2, "os.link": 2, "os.symlink": 2, "sqlite3.connect": 1,
}  # fmt: skip
"""Event -> number of its arguments that are paths."""
_LOOKUPS = ("socket.getaddrinfo", "socket.gethostbyname", "socket.gethostbyaddr")
_CONNECTIONS = ("socket.connect", "socket.sendto", "socket.sendmsg")
_NOBODY = ("192.0.2.0/24", "198.51.100.0/24", "203.0.113.0/24", "240.0.0.0/4", "2001:db8::/32")
_RESERVED = ("localhost", "invalid", "test", "example")
_busy = _local()


def install(state: dict[str, Any]) -> None:
    """Watch this process from now on; another call replaces the rules.

    Args:
        state: "guarded" and "free" are lists of folders, "report" is the file for notes.
    """
    clean = {**state, "guarded": _folders(state["guarded"]), "free": _folders(state["free"])}
    if hasattr(sys, "_tests_watch"):
        sys._tests_watch.update(clean)
        return
    sys._tests_watch = clean  # type: ignore[attr-defined]
    sys.addaudithook(_hook)


def install_from_environment() -> None:
    """Watch this process by the rules of its parent process, if any."""
    text = os.environ.get(VARIABLE)
    if text:
        import json

        install(json.loads(text))


def _folders(paths: list[str]) -> list[str]:
    return [_normal(path) for path in paths if path]


def _normal(path: str) -> str:
    return os.path.normcase(os.path.abspath(path)).rstrip(os.sep) + os.sep


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if event in _PATHS:
        if not getattr(_busy, "yes", False):
            _judge(event, _wrong_path(arguments[: _PATHS[event]]))
    elif event[:7] == "socket." and not getattr(_busy, "yes", False):
        if event in _CONNECTIONS:
            _judge(event, _wrong_address(*arguments[:2], event))
        elif event in _LOOKUPS:
            _judge(event, _wrong_name(arguments[0]))


def _judge(event: str, wrong: str | None) -> None:
    if wrong is None:
        return
    line = f"{event} {wrong} by {' '.join(map(str, getattr(sys, 'argv', ['?'])))[:200]!r}"
    _busy.yes = True
    try:
        state = sys._tests_watch  # type: ignore[attr-defined]
        with open(state["report"], "a", encoding="utf-8") as report:
            report.write(line + "\n")
    except OSError:
        pass  # the test run has ended
    finally:
        _busy.yes = False
    raise PermissionError(explain(line))


def explain(line: str) -> str:
    """The error message for a line of the report."""
    return (
        f"no test may touch the user's folders or another machine: {line}; give it a folder of its own"
        " (tmp_path), or 127.0.0.1"
    )


# -- files -------------------------------------------------------------------------------------------------


def _wrong_path(paths: tuple[Any, ...]) -> str | None:
    for path in paths:
        if isinstance(path, (str, bytes, os.PathLike)):
            full = _full(os.fsdecode(path))
            if full is not None and _depth(full, "guarded") >= max(1, _depth(full, "free")):
                return full.rstrip(os.sep)
    return None


def _full(path: str) -> str | None:
    _busy.yes = True
    try:
        return _normal(path)
    except OSError:  # the working directory was removed
        return None
    finally:
        _busy.yes = False


def _depth(path: str, kind: str) -> int:
    """Length of the deepest folder of that kind that contains the path; 0 if there is none."""
    folders = sys._tests_watch[kind]  # type: ignore[attr-defined]
    return max((len(folder) for folder in folders if path.startswith(folder)), default=0)


# -- the network -------------------------------------------------------------------------------------------


def _wrong_address(sock: Any, address: Any, event: str) -> str | None:
    if not isinstance(address, tuple) or not address or os.environ.get(NETWORK) == "own":
        return None  # a local socket, a device, a connected socket that sends
    if event == "socket.connect" and sock.type & 0xF == 2:  # SOCK_DGRAM
        return None
    from ipaddress import ip_network

    host = address[0]
    number = _number(host)
    if number is None:
        return _wrong_name(host)
    if number.is_loopback or number.is_unspecified or any(number in ip_network(text) for text in _NOBODY):
        return None
    return None if _is_ours(sock.family, str(number)) else f"{host}:{address[1]}"


def _wrong_name(host: Any) -> str | None:
    """Describe a host name that needs a lookup on another machine; None if it needs none."""
    name = os.fsdecode(host or "localhost").rstrip(".").lower()
    if _number(name) is not None or name.rpartition(".")[2] in _RESERVED or not name.isprintable():
        return None
    own = sys.modules["socket"].gethostname().lower() if "socket" in sys.modules else ""
    if name in (own, own.partition(".")[0]) or os.environ.get(NETWORK) == "own":
        return None
    return f"of the name {name!r}"


def _number(host: Any) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    from ipaddress import ip_address

    try:
        number = ip_address(os.fsdecode(host).partition("%")[0])
    except ValueError:
        return None
    return getattr(number, "ipv4_mapped", None) or number


def _is_ours(family: int, host: str) -> bool:
    """True for an address of this machine: no other can be bound."""
    import socket

    _busy.yes = True
    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.bind((host, 0))
        return True
    except OSError:
        return False
    finally:
        _busy.yes = False
