"""List the addresses of this computer's network interfaces.

Python has no function for it, so this calls getifaddrs(3) on POSIX and GetAdaptersAddresses on Windows. Where
neither exists, the resolver is asked for the computer's own name, which may miss some.
"""

from __future__ import annotations

import ctypes
import os
import socket
import sys
from collections.abc import Iterator


class _Entry(ctypes.Structure):
    """struct ifaddrs, the fields that all systems share."""


_Entry._fields_ = [
    ("next", ctypes.POINTER(_Entry)),
    ("name", ctypes.c_char_p),
    ("flags", ctypes.c_uint),
    ("address", ctypes.c_void_p),
]


class _Address(ctypes.Structure):
    """IP_ADAPTER_UNICAST_ADDRESS, the fields that are used."""


_Address._fields_ = [
    ("size_and_flags", ctypes.c_uint64),
    ("next", ctypes.POINTER(_Address)),
    ("address", ctypes.c_void_p),
]


class _Adapter(ctypes.Structure):
    """IP_ADAPTER_ADDRESSES, the fields that are used."""


_Adapter._fields_ = [
    ("size_and_index", ctypes.c_uint64),
    ("next", ctypes.POINTER(_Adapter)),
    ("name", ctypes.c_char_p),
    ("addresses", ctypes.POINTER(_Address)),
    ("other_addresses", ctypes.c_void_p * 3),
    ("texts", ctypes.c_void_p * 3),
    ("hardware_address", ctypes.c_ubyte * 8),
    ("numbers", ctypes.c_uint32 * 4),
    ("state", ctypes.c_uint32),
]

_UP = 1
"""The adapter is up; it is not possible to listen on the address of one that is down."""
_ONLY_UNICAST = 0x2 | 0x4 | 0x8 | 0x20
_TOO_SMALL, _NONE_THERE = 111, 232  # ERROR_BUFFER_OVERFLOW, ERROR_NO_DATA

_FAMILIES = {int(socket.AF_INET): (4, 4), int(socket.AF_INET6): (8, 16)}
"""Offset and length of the address in a socket address; the same on Linux, macOS and the BSDs."""


def interface_addresses(family: socket.AddressFamily = socket.AF_INET) -> list[str]:
    """Numeric addresses of all interfaces, loopback included, in the system's order, without repetition.

    A link-local IPv6 address names its interface (`fe80::1%eth0`). Empty if the system gives none.
    """
    try:
        found = list(_posix(family) if os.name == "posix" else _windows(family))
    except (OSError, AttributeError):  # no such function in this system's library
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


def _windows(family: socket.AddressFamily) -> Iterator[str]:
    library = getattr(ctypes, "windll").iphlpapi  # noqa: B009  (absent elsewhere)
    size = ctypes.c_ulong(16 * 1024)
    for _ in range(4):  # an interface may appear between the two calls
        room = ctypes.create_string_buffer(size.value)
        status = library.GetAdaptersAddresses(int(family), _ONLY_UNICAST, None, room, ctypes.byref(size))
        if status != _TOO_SMALL:
            break
    if status == _NONE_THERE:
        return
    if status != 0:
        raise OSError(status, f"GetAdaptersAddresses: status {status}")
    adapter = ctypes.cast(room, ctypes.POINTER(_Adapter))
    while adapter:
        entry = adapter.contents.addresses if adapter.contents.state == _UP else None
        while entry:
            yield _number(entry.contents.address, family)
            entry = entry.contents.next
        adapter = adapter.contents.next


def _number(address: int, family: socket.AddressFamily) -> str:
    at, size = _FAMILIES[int(family)]
    text = socket.inet_ntop(family, ctypes.string_at(address + at, size))
    if not text.startswith("fe80:"):
        return text
    scope = int.from_bytes(ctypes.string_at(address + 24, 4), sys.byteorder)
    return f"{text}%{scope}" if scope else text


def _of_the_name(family: socket.AddressFamily) -> list[str]:
    try:
        found = [str(info[4][0]) for info in socket.getaddrinfo(socket.gethostname(), None, family)]
    except OSError:
        return []
    return [*found, "127.0.0.1" if family == socket.AF_INET else "::1"]
