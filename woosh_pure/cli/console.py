"""The whole screen of a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rosproto.cli import enable_escapes, is_terminal, own, shows_unicode, terminal_size

__all__ = ["enable_escapes", "full_screen", "is_terminal", "shows_unicode", "terminal_size"]


@contextmanager
def full_screen(stream: TextIO) -> Iterator[None]:
    """The other screen of the terminal, without a cursor; what was there before comes back, always."""
    own(stream).write("\x1b[?1049h\x1b[?25l\x1b[2J")
    stream.flush()
    try:
        yield
    finally:
        own(stream).write("\x1b[?25h\x1b[?1049l")
        stream.flush()
