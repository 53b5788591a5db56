"""The progress line of a long command, on stderr; not shown in the first second.

A thread writes it, also during a long step, such as a slow server's answer; the steps are only counted.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from typing import TextIO

from rosproto.cli.console import is_terminal, own
from rosproto.text import cut, human_bytes, padded, printable, width

FIRST_AFTER = 1.0
EVERY = 0.25


class Progress:
    """Reports progress in one line that is overwritten; use it in a `with` block.

    Args:
        what: For example "compressing run.bag"; with "" only `show` sets the line.
        total: Number of steps; None if unknown.
        stream: Output; nothing is written unless it is a terminal.
        quiet: Write nothing.
        in_bytes: The steps are bytes.
        announced: Print `what ...` once where the stream is not a terminal.

    Attributes:
        on: Whether the line is written.
    """

    def __init__(
        self,
        what: str,
        total: int | None = None,
        *,
        stream: TextIO | None = None,
        quiet: bool = False,
        in_bytes: bool = False,
        announced: bool = False,
    ) -> None:
        self._what = what
        self._total = total
        self._stream = stream or sys.stderr
        self._quiet = quiet
        self.on = not quiet and is_terminal(self._stream)
        self._announced = announced and not quiet
        self._began = time.monotonic()
        self._shown = 0
        self._count = 0
        self._in_bytes = in_bytes
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._ticker: threading.Thread | None = None

    def __enter__(self) -> Progress:
        if self._what and (self.on or self._announced):
            ticker = threading.Thread(target=self._tick, name="rosproto:progress", daemon=True)
            try:
                ticker.start()
            except RuntimeError:
                return self  # no thread can be started: a stop must not fail for missing output
            self._ticker = ticker
        return self

    def __exit__(self, *exc: object) -> None:
        self._ended.set()
        if self._ticker is not None:
            self._ticker.join(1.0)  # Ctrl-S may block the thread
        self.clear()

    def _tick(self) -> None:
        pause = FIRST_AFTER
        while not self._ended.wait(pause):
            pause = EVERY
            with self._lock:
                text = self.text(time.monotonic() - self._began)
            try:
                if not self.on:
                    self.note(f"{self._what} ...")
                    return
                self.show(_end_of(text, _room()))
            except (OSError, ValueError):
                return  # the terminal has gone: the command detects it

    def step(self, count: int = 1) -> None:
        """Add `count` to the steps done; cheap enough to call for each message."""
        self._count += count

    def at(self, done: int, total: int | None = None) -> None:
        """Report `done` of `total`; without `total` the previous one stays."""
        self._count = done
        self._total = total or self._total

    def go_on(self, what: str, total: int) -> None:
        """Begin the next part of the work, with `total` steps that are not bytes."""
        with self._lock:
            self._what, self._total, self._count, self._in_bytes = what, total, 0, False
            self._began = time.monotonic()

    def text(self, seconds: float) -> str:
        """Return the line after `seconds`."""
        rate = self._count / seconds if seconds > 0 else 0.0
        if not rate and seconds >= FIRST_AFTER:  # no estimate before the first step
            return f"{self._what}: {seconds:.0f} s"
        speed = f"{human_bytes(rate)}/s" if self._in_bytes else f"{rate:.0f}/s"
        if not self._total:
            done = human_bytes(self._count) if self._in_bytes else self._count
            return f"{self._what}: {done} ({speed})"
        left = max(0, self._total - self._count) / rate if rate else 0.0
        return f"{self._what}: {100 * self._count // self._total} % ({speed}, {left:.0f} s left)"

    def show(self, text: str) -> None:
        """Overwrite the line."""
        if not self.on:
            return
        text = cut(printable(text), _room())
        own(self._stream).write("\r" + padded(text, self._shown))
        self._stream.flush()
        self._shown = width(text)

    def note(self, text: str) -> None:
        """Print a line of its own, also where the stream is not a terminal; nothing when quiet."""
        if not self._quiet:
            print(text, file=self._stream, flush=True)

    def leave(self) -> None:
        """End the line, which stays on the screen."""
        if self._shown:
            own(self._stream).write("\n")
            self._shown = 0

    def clear(self) -> None:
        """Erase the line."""
        if self.on and self._shown:
            own(self._stream).write("\r" + " " * self._shown + "\r")
            self._stream.flush()
            self._shown = 0


def _room() -> int:
    """Return the maximum columns of a line that can be overwritten."""
    return shutil.get_terminal_size().columns - 1


def _end_of(text: str, room: int) -> str:
    """Shorten a line from the left: its numbers are at the end."""
    if width(text) <= room:
        return text
    while text and width(text) > room - 3:
        text = text[1:]
    return "..." + text
