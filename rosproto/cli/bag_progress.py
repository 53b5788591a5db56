"""A line on stderr that tells how far a long command has come; silent for what takes less than a second."""

from __future__ import annotations

import shutil
import sys
import time
from typing import TextIO

from rosproto.text import cut, padded, printable, width

from .streams import own

__all__ = ["Progress"]

FIRST_AFTER = 1.0
EVERY = 0.25


class Progress:
    """Tells progress in one line that is written over; use it in a `with` block.

    Args:
        what: For example "compressing run.bag".
        total: How many steps there are; None when nobody knows.
        stream: A terminal, else nothing is written.
        quiet: Write nothing.
    """

    def __init__(
        self, what: str, total: int | None = None, *, stream: TextIO | None = None, quiet: bool = False
    ) -> None:
        self._what = what
        self._total = total
        self._stream = stream or sys.stderr
        self._on = not quiet and self._stream.isatty()
        self._began = time.monotonic()
        self._due = self._began + FIRST_AFTER
        self._shown = 0
        self._count = 0

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *exc: object) -> None:
        self.clear()

    def step(self, count: int = 1) -> None:
        """So many more are done; cheap enough to be called for each message."""
        self._count += count
        # Small steps come by the thousand: the clock is not asked each time.
        if self._on and (count > 1 or not self._count & 63 or (self._total or 1024) < 1024):
            self._look()

    def expect(self, total: int) -> None:
        """How many steps there are, where that turns out only now."""
        self._total = total

    def tell(self, text: str) -> None:
        """Show this, if it has taken long enough already."""
        if time.monotonic() >= self._due:
            self.show(text)

    def _look(self) -> None:
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + EVERY
        self.show(self.text(now - self._began))

    def text(self, seconds: float) -> str:
        """The line after so many seconds."""
        rate = self._count / seconds if seconds > 0 else 0.0
        if not self._total:
            return f"{self._what}: {self._count} ({rate:.0f}/s)"
        left = (self._total - self._count) / rate if rate else 0.0
        return f"{self._what}: {100 * self._count // self._total} % ({rate:.0f}/s, {left:.0f} s left)"

    def show(self, text: str) -> None:
        """Write over the line."""
        if self._on:
            room = shutil.get_terminal_size().columns - 1  # a longer line could not be written over
            text = cut(printable(text), room)
            own(self._stream).write("\r" + padded(text, self._shown))
            self._stream.flush()
            self._shown = width(text)

    def clear(self) -> None:
        """Take the line away."""
        if self._on and self._shown:
            own(self._stream).write("\r" + " " * self._shown + "\r")
            self._stream.flush()
            self._shown = 0
