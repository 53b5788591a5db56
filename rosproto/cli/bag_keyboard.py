"""Single keys from the terminal, without waiting for Enter: on POSIX and on Windows consoles."""

from __future__ import annotations

import os
import sys
from types import TracebackType
from typing import Any

__all__ = ["Keyboard"]


class Keyboard:
    """Keys typed since the last look; use it in a `with` block, which gives the terminal back as it was.

    Without a terminal (a pipe, a service) there are no keys, and nothing fails.

    Attributes:
        available: Whether keys can be had.
    """

    def __init__(self) -> None:
        self.available = False
        self._fd = -1
        self._saved: Any = None
        self._windows = sys.platform == "win32"

    def __enter__(self) -> Keyboard:
        if sys.stdin is None or not sys.stdin.isatty():
            return self
        if not self._windows:
            self._to_single_keys()
        self.available = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._saved is not None and sys.platform != "win32":
            import termios

            termios.tcsetattr(self._fd, termios.TCSADRAIN, self._saved)
        self.available = False

    def typed(self) -> str:
        """What was typed, "" when nothing; never waits."""
        if not self.available:
            return ""
        return self._windows_keys() if self._windows else self._posix_keys()

    def _to_single_keys(self) -> None:
        if sys.platform == "win32":
            return
        import termios
        import tty

        self._fd = sys.stdin.fileno()
        self._saved = termios.tcgetattr(self._fd)
        tty.setcbreak(self._fd)  # Ctrl-C stays a signal

    def _posix_keys(self) -> str:
        import select

        if not select.select([self._fd], [], [], 0)[0]:
            return ""
        return os.read(self._fd, 64).decode("ascii", "replace")

    def _windows_keys(self) -> str:
        import importlib

        console: Any = importlib.import_module("msvcrt")
        typed = ""
        while console.kbhit():
            typed += console.getwch()
        return typed
