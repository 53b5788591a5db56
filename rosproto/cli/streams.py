"""Output that the encoding cannot express: a command prints something readable instead of failing."""

from __future__ import annotations

import codecs
import io
import os
import sys
from collections.abc import Sequence

__all__ = ["as_typed", "escape_what_cannot_be_printed"]

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
