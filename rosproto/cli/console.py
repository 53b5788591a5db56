"""The terminal on any OS, and printing to it: nothing that a peer sent can control it.

While a command runs, `sys.stdout` and `sys.stderr` escape every control character, direction mark and
invisible one (see `rosproto.text`) except line ends and tabs. So a print of anything, from anywhere, is safe;
what moves the cursor or colours is our own and says so: `own(stream).write("\\r...")`. A peer's text that
must not begin a line either (a name, an error, a cell) goes through `printable` where it is put into one.
Nothing fails for want of characters, either.
"""

from __future__ import annotations

import codecs
import io
import json
import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from rosproto.text import printable

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


class OutputError(OSError):
    """Standard output or error cannot be written, as on a full disk; BrokenPipeError is raised as it is."""

    @classmethod
    def of(cls, error: OSError) -> OSError:
        """The exception for a system error of an output stream, which could be taken for another file's."""
        if isinstance(error, (cls, BrokenPipeError)):
            return error
        return cls(error.errno, error.strerror or str(error))


class EscapingStream:
    """A text stream whose controls are escaped; everything else is that stream's."""

    def __init__(self, stream: TextIO) -> None:
        self.unguarded = stream

    def write(self, text: str) -> int:
        """Write it, fit for a terminal; the number of its characters.

        Raises:
            OutputError: It cannot be written; also from what was handed over before.
        """
        try:
            self.unguarded.write(printable(text, keep="\n\t"))
        except OSError as error:
            raise OutputError.of(error) from None
        return len(text)

    def flush(self) -> None:
        """Hand over what waits; errors as `write`."""
        try:
            self.unguarded.flush()
        except OSError as error:
            raise OutputError.of(error) from None

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
    ours: Any = [stream if stream is None else EscapingStream(own(stream)) for stream in before]
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


_NOT_ASCII = re.compile(r"[^\x00-\x7e]+")


def json_text(value: object, *, ascii_only: bool = False, **options: Any) -> str:
    """`json.dumps`, with letters as they are and everything that is not printable as `\\u202e`.

    Args:
        value: What `json.dumps` takes.
        ascii_only: Escape all that is not ASCII.
        options: Handed on to `json.dumps`.
    """
    text = json.dumps(value, ensure_ascii=ascii_only, **options)
    return text if text.isprintable() else _NOT_ASCII.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    return "".join(c if c.isprintable() or c == "\u3000" else json.dumps(c)[1:-1] for c in found[0])


def warn(text: str) -> None:
    """A line on stderr that does not end the command."""
    print(printable(f"WARNING: {text}"), file=sys.stderr, flush=True)


def print_json(value: object) -> None:
    """Print one line of JSON."""
    print(json_text(value, ascii_only=not shows_unicode(sys.stdout), default=str))


def counted(number: int, thing: str, things: str | None = None) -> str:
    """The number and what it counts, in the singular or plural.

    Args:
        number: How many.
        thing: One of them: "message".
        things: Several of them, where an s does not do: "retries".
    """
    return f"{number} {thing if number == 1 else things or thing + 's'}"
