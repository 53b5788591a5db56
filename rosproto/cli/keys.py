"""Single keys from a terminal, on POSIX (termios) and Windows (msvcrt); the terminal is restored, always.

Keys have names: "up", "down", "left", "right", "escape", "other" (a key without a name here), and printable
ones are themselves, in lower case.
"""

from __future__ import annotations

import errno
import os
import select
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

from rosproto.cli.console import TerminalGone

_SEQUENCES = {"A": "up", "B": "down", "C": "right", "D": "left"}
_WINDOWS = {"H": "up", "P": "down", "M": "right", "K": "left"}
_ESCAPE_PATIENCE = 0.03
"""Seconds after which a lone escape byte is the escape key and not the begin of a sequence."""


class Keys(Protocol):
    """A source of keys."""

    def read(self, timeout: float) -> list[str]:
        """Return all pending keys, oldest first; wait up to `timeout` s for the first.

        Raises:
            TerminalGone: The terminal was closed.
        """


class KeyDecoder:
    """Converts bytes of a POSIX terminal to key names; sequences may be split. Pure."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def pending(self) -> bool:
        """Whether a sequence is incomplete."""
        return bool(self._rest)

    def feed(self, data: bytes) -> list[str]:
        """Add bytes and return the complete keys."""
        self._rest += data
        keys: list[str] = []
        while self._rest:
            length, key = self._first()
            if length == 0:
                break
            self._rest = self._rest[length:]
            keys.append(key)
        return keys

    def flush(self) -> list[str]:
        """End an incomplete sequence: a single escape is the escape key."""
        rest, self._rest = self._rest, b""
        return [] if not rest else ["escape" if rest == b"\x1b" else "other"]

    def _first(self) -> tuple[int, str]:
        """Return length and name of the first key, (0, "") if incomplete."""
        data = self._rest
        if data[0] != 0x1B:
            return _character(data)
        if len(data) == 1:
            return 0, ""
        if data[1:2] not in (b"[", b"O"):
            return 2, "other"  # Alt and a key
        # ECMA-48 5.4: parameters 0x20-0x3F, then one final byte 0x40-0x7E.
        for at in range(2, min(len(data), 32)):
            if 0x40 <= data[at] <= 0x7E:
                plain = at == 2
                return at + 1, _SEQUENCES.get(chr(data[at]), "other") if plain else "other"
        return (0, "") if len(data) < 32 else (len(data), "other")


def _character(data: bytes) -> tuple[int, str]:
    first = data[0]
    # The first byte of a character in UTF-8 says how many follow.
    length = 1 if first < 0xC0 else 2 if first < 0xE0 else 3 if first < 0xF0 else 4
    if len(data) < length:
        return 0, ""
    text = data[:length].decode("utf-8", "replace").lower()
    return length, text if len(text) == 1 and text.isprintable() else "other"


class _PosixKeys:
    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._decoder = KeyDecoder()

    def read(self, timeout: float) -> list[str]:
        """See `Keys`."""
        if not self._ready(timeout):
            return []
        keys: list[str] = []
        while True:
            data = self._bytes()
            keys += self._decoder.feed(data)
            if not self._ready(_ESCAPE_PATIENCE if self._decoder.pending else 0.0):
                return keys + self._decoder.flush()

    def _bytes(self) -> bytes:
        try:
            data = os.read(self._descriptor, 1024)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            data = b""
        if not data:  # Ctrl-D is a key like the others here
            raise TerminalGone(errno.EIO, os.strerror(errno.EIO))
        return data

    def _ready(self, timeout: float) -> bool:
        return bool(select.select([self._descriptor], [], [], max(0.0, timeout))[0])


class WindowsKeys:
    """Keys of a Windows console.

    Args:
        console: The module msvcrt, or something like it.
    """

    def __init__(self, console: Any) -> None:
        self._console = console

    def read(self, timeout: float) -> list[str]:
        """See `Keys`."""
        from rosproto.transport import Deadline  # late: `--help` loads no sockets

        deadline = Deadline(timeout)
        while not self._console.kbhit():
            if deadline.expired:
                return []
            time.sleep(0.01)
        keys = []
        while self._console.kbhit():
            keys.append(self._key())
        return keys

    def _key(self) -> str:
        character = self._console.getwch()
        if character == "\x03":
            raise KeyboardInterrupt  # during a read, the console reports Ctrl-C as a key
        if character in ("\x00", "\xe0"):
            return _WINDOWS.get(self._console.getwch(), "other")
        if character == "\x1b":
            return "escape"
        return character.lower() if character.isprintable() else "other"


@contextmanager
def open_keys(*, driving: bool = True) -> Iterator[Keys]:
    """Single keys from standard input, without Enter and without echo; Ctrl-C still interrupts.

    Args:
        driving: Ctrl-Z is an ordinary key (a suspended program cannot stop a robot), and unread keys are
            discarded, so that the shell does not run them.
    """
    if sys.platform == "win32":
        import msvcrt

        yield WindowsKeys(msvcrt)
        return
    import termios
    import tty

    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    try:
        # Now, without waiting for the output: its reader may be gone.
        tty.setcbreak(descriptor, termios.TCSANOW)
        if driving:
            mode = termios.tcgetattr(descriptor)
            disabled = os.fpathconf(descriptor, "PC_VDISABLE")
            for name in ("VSUSP", "VDSUSP", "VSTOP"):
                if hasattr(termios, name):
                    mode[6][getattr(termios, name)] = bytes([disabled & 0xFF])
            termios.tcsetattr(descriptor, termios.TCSANOW, mode)
        yield _PosixKeys(descriptor)
    finally:
        with suppress(termios.error):  # the terminal was closed
            if driving:
                termios.tcflush(descriptor, termios.TCIFLUSH)
            termios.tcsetattr(descriptor, termios.TCSANOW, before)
