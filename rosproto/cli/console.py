"""What a terminal can do, on any OS: escape sequences, colours, characters, size."""

from __future__ import annotations

import os
import sys
from typing import TextIO

from .streams import own

__all__ = ["clear", "enable_escapes", "is_terminal", "shows_unicode", "terminal_size"]

# learn.microsoft.com/windows/console/setconsolemode
_STD_OUTPUT, _STD_ERROR = -11, -12
_PROCESSED_OUTPUT, _VIRTUAL_TERMINAL = 0x1, 0x4


def is_terminal(stream: TextIO | None) -> bool:
    """True when a person reads this stream; a closed or missing stream is none."""
    try:
        return stream is not None and stream.isatty()
    except ValueError:
        return False


def terminal_size() -> tuple[int, int]:
    """Columns and lines of the terminal."""
    import shutil

    columns, lines = shutil.get_terminal_size((80, 24))
    return columns, lines


def shows_unicode(stream: TextIO | None) -> bool:
    """True when bars, dots and box characters can be written to it."""
    return (getattr(stream, "encoding", None) or "").lower().startswith("utf")


def clear(stream: TextIO) -> None:
    """Empty the screen; where there is none, or none that understands, nothing happens."""
    if enable_escapes(stream):
        own(stream).write("\x1b[2J\x1b[H")


def enable_escapes(stream: TextIO | None) -> bool:
    """Whether escape sequences work on `stream`; a Windows console is asked to understand them."""
    if not is_terminal(stream):
        return False
    if sys.platform != "win32":
        return os.environ.get("TERM", "") not in ("", "dumb")
    return _enable_on_windows(_STD_ERROR if stream is sys.stderr else _STD_OUTPUT)


def _enable_on_windows(which: int) -> bool:  # pragma: no cover  (Windows only)
    try:
        import ctypes

        kernel = getattr(ctypes, "windll").kernel32  # noqa: B009  (absent elsewhere)
        handle, mode = kernel.GetStdHandle(which), ctypes.c_uint32()
        if not kernel.GetConsoleMode(handle, ctypes.byref(mode)):
            return False
        return bool(kernel.SetConsoleMode(handle, mode.value | _PROCESSED_OUTPUT | _VIRTUAL_TERMINAL))
    except (AttributeError, ImportError, OSError):
        return False
