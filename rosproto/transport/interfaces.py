"""The addresses of this computer's network cards.

Python has no function for it. POSIX systems have getifaddrs(3); on Windows the system's own resolver gives
the addresses of all cards for the computer's name.
"""

from __future__ import annotations

import ctypes
import os
import socket
import sys
from collections.abc import Iterator

__all__ = ["interface_addresses"]


class _Entry(ctypes.Structure):
    """struct ifaddrs, as far as it is the same everywhere."""


_Entry._fields_ = [
    ("next", ctypes.POINTER(_Entry)),
    ("name", ctypes.c_char_p),
    ("flags", ctypes.c_uint),
    ("address", ctypes.c_void_p),
]

_FAMILIES = {int(socket.AF_INET): (4, 4), int(socket.AF_INET6): (8, 16)}
"""Where in a socket address the numbers are, and how many bytes; the same on Linux, macOS and the BSDs."""


def interface_addresses(family: socket.AddressFamily = socket.AF_INET) -> list[str]:
    """Numeric addresses of all cards, the loopback's too, in the system's order and each once.

    An IPv6 address of a link names its card (`fe80::1%eth0`). Empty when the system tells none.
    """
    try:
        found = list(_posix(family) if os.name == "posix" else _resolved(family))
    except (OSError, AttributeError):  # no such function in this C library
        found = _of_the_name(family)
    return list(dict.fromkeys(found))


def _posix(family: socket.AddressFamily) -> Iterator[str]:
    library = ctypes.CDLL(None, use_errno=True)
    first = ctypes.POINTER(_Entry)()
    if library.getifaddrs(ctypes.byref(first)) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    try:
        entry = first
        while entry:
            if entry.contents.address:
                yield from _numeric(entry.contents, family)
            entry = entry.contents.next
    finally:
        library.freeifaddrs(first)


def _numeric(entry: _Entry, family: socket.AddressFamily) -> Iterator[str]:
    head = ctypes.string_at(entry.address, 2)
    # The BSDs put the length in front of the family.
    present = int.from_bytes(head, sys.byteorder) if sys.platform.startswith("linux") else head[1]
    if present != family:
        return
    at, size = _FAMILIES[int(family)]
    text = socket.inet_ntop(family, ctypes.string_at(entry.address + at, size))
    yield f"{text}%{entry.name.decode()}" if text.startswith("fe80:") else text


def _resolved(family: socket.AddressFamily) -> Iterator[str]:
    for info in socket.getaddrinfo(socket.gethostname(), None, family):
        yield str(info[4][0])
    yield "127.0.0.1" if family == socket.AF_INET else "::1"


def _of_the_name(family: socket.AddressFamily) -> list[str]:
    try:
        return list(_resolved(family))
    except OSError:
        return []
