"""What commands print: a terminal obeys nothing of a peer's, and nothing fails for want of characters.

While a command runs, `sys.stdout` and `sys.stderr` escape every control character, direction mark and
invisible one (see `rosproto.text`) except line ends and tabs. So a print of anything, from anywhere, is safe;
what moves the cursor or colours is our own and says so: `own(stream).write("\\r...")`. A peer's text that
must not begin a line either (a name, an error, a cell) goes through `printable` where it is put into one.
"""

from __future__ import annotations

import codecs
import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from rosproto.text import printable

__all__ = ["as_typed", "escape_what_cannot_be_printed", "guarded", "own", "unguarded"]

_READABLE = {
    "°": "deg", "²": "2", "→": "->", "←": "<-", "↑": "^", "↓": "v", "…": "...", "µ": "u", "–": "-", "×": "x",
    "█": "#", "░": "-", "•": "*", "·": ".", "┤": "|", "│": "|", "├": "|", "└": "`", "─": "-",
}  # fmt: skip
"""What our own output says in ASCII; anything else becomes an escape such as `\\u6025`."""


def escape_what_cannot_be_printed() -> None:
    """Let stdout and stderr write `deg` for a degree sign that they lack; what has no such form is escaped.

    A pipe on Windows has the machine's code page (cp1252), and so has Linux with LC_ALL=C in part: neither
    knows the bars, trees, arrows and Chinese texts of robots. A console on Windows shows all of them.
    """
    if sys.stdout is None:  # closed by a shell (>&-), or absent as under pythonw.exe
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (for the whole process)
    codecs.register_error("rosproto.readable", _readable)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="rosproto.readable")


class Guarded:
    """A text stream whose controls are escaped; everything else is that stream's."""

    def __init__(self, stream: TextIO) -> None:
        self.unguarded = stream

    def write(self, text: str) -> int:
        """Write it, fit for a terminal; the number of its characters."""
        self.unguarded.write(printable(text, keep="\n\t"))
        return len(text)

    def writelines(self, lines: Sequence[str]) -> None:
        """Write each of them."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unguarded, name)


@contextmanager
def guarded() -> Iterator[None]:
    """Within the block stdout and stderr escape what a terminal would obey."""
    before: Any = sys.stdout, sys.stderr
    ours: Any = [stream if stream is None else Guarded(own(stream)) for stream in before]
    sys.stdout, sys.stderr = ours
    try:
        yield
    finally:
        if [sys.stdout, sys.stderr] == ours:
            sys.stdout, sys.stderr = before


@contextmanager
def unguarded() -> Iterator[None]:
    """Within the block they are as they were: a program of the user's prints what it likes."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = own(sys.stdout), own(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def own(stream: TextIO) -> TextIO:
    """The stream for what this program itself wants the terminal to obey."""
    inner: TextIO = getattr(stream, "unguarded", stream)
    return inner


def as_typed(words: Sequence[str]) -> list[str]:
    """The arguments of a terminal that types UTF-8 although the locale (LC_ALL=C) does not say so.

    Python hands over bytes without a character in its locale as lone surrogates; YAML and JSON refuse those.
    """
    found = []
    for word in words:
        try:
            found.append(word.encode("utf-8", "surrogateescape").decode("utf-8"))
        except UnicodeError:
            found.append(word)  # no UTF-8: left as it came
    return found


def _readable(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    if error.object[error.start] not in _READABLE:
        one = UnicodeEncodeError(error.encoding, error.object, error.start, error.start + 1, error.reason)
        return codecs.backslashreplace_errors(one)
    return _READABLE[error.object[error.start]], error.start + 1
