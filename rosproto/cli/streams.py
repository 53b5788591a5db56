"""Output that the encoding cannot express: a command prints an escape instead of failing."""

from __future__ import annotations

import io
import sys

__all__ = ["escape_what_cannot_be_printed"]


def escape_what_cannot_be_printed() -> None:
    """Let stdout and stderr write `\\u2514` for a character that they lack.

    A pipe on Windows has the machine's code page (cp1252), and so has Linux with LC_ALL=C in part: neither
    knows the bars, trees, arrows and Chinese texts of robots. A console on Windows shows all of them.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
