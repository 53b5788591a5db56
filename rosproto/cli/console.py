"""The terminal on any OS, and printing to it: text of a peer cannot control the terminal.

While a command runs, `sys.stdout` and `sys.stderr` escape control characters, direction marks and invisible
characters (see `rosproto.text`) except line ends and tabs. So every print is safe. Our own control sequences
use `own(stream).write("\\r...")`. A peer's text inside a line (a name, an error, a cell) goes through
`printable`, which escapes line ends, too. Characters that the encoding lacks raise no error.
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

from rosproto.sentence import Sentence, say
from rosproto.text import printable

# learn.microsoft.com/windows/console/setconsolemode
_STD_OUTPUT, _STD_ERROR = -11, -12
_PROCESSED_OUTPUT, _VIRTUAL_TERMINAL = 0x1, 0x4


def is_terminal(stream: TextIO | None) -> bool:
    """Whether the stream is a terminal; False for a closed or missing one."""
    try:
        return stream is not None and stream.isatty()
    except ValueError:
        return False


def terminal_size() -> tuple[int, int]:
    """Return columns and lines of the terminal."""
    import shutil

    columns, lines = shutil.get_terminal_size((80, 24))
    return columns, lines


def shows_unicode(stream: TextIO | None) -> bool:
    """Whether the stream can encode bars, dots and box characters."""
    return (getattr(stream, "encoding", None) or "").lower().startswith("utf")


def clear(stream: TextIO) -> None:
    """Clear the screen, if the stream is a terminal with escape sequences."""
    if enable_escapes(stream):
        own(stream).write("\x1b[2J\x1b[H")


def enable_escapes(stream: TextIO | None) -> bool:
    """Whether escape sequences work on `stream`; enables them on a Windows console."""
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
    """Let stdout and stderr replace a character that they lack (`deg` for a degree sign) or escape it.

    A pipe on Windows (cp1252) and Linux with LC_ALL=C lack bars, trees, arrows and Chinese. A Windows console
    shows all of them.
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
        """Convert a stream's system error, to distinguish it from those of other files."""
        if isinstance(error, (cls, BrokenPipeError)):
            return error
        return cls(error.errno, error.strerror or str(error))


class TerminalGone(OutputError):
    """The terminal was closed (EIO). SIGHUP says so, too, but may come later than the failed write, or not at
    all: only the programs of the terminal's session get it.
    """


class EscapingStream:
    """A text stream that escapes control characters; other attributes are the stream's."""

    def __init__(self, stream: TextIO) -> None:
        self.unguarded = stream

    def write(self, text: str) -> int:
        """Write the escaped text; return its number of characters.

        Raises:
            OutputError: It, or earlier text, cannot be written.
        """
        try:
            self.unguarded.write(printable(text, keep="\n\t"))
        except OSError as error:
            raise OutputError.of(error) from None
        return len(text)

    def flush(self) -> None:
        """Flush the stream; errors as `write`."""
        try:
            self.unguarded.flush()
        except OSError as error:
            raise OutputError.of(error) from None

    def writelines(self, lines: Sequence[str]) -> None:
        """Write each line."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unguarded, name)


@contextmanager
def guarded() -> Iterator[None]:
    """Let stdout and stderr escape control characters within the block."""
    before = sys.stdout, sys.stderr
    ours: Any = [stream if stream is None else EscapingStream(own(stream)) for stream in before]
    sys.stdout, sys.stderr = ours
    try:
        yield
    finally:
        if [sys.stdout, sys.stderr] == ours:
            sys.stdout, sys.stderr = before


@contextmanager
def unguarded() -> Iterator[None]:
    """Restore stdout and stderr within the block, for a program of the user."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = own(sys.stdout), own(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def own(stream: TextIO) -> TextIO:
    """Return the stream for this program's own control sequences."""
    inner: TextIO = getattr(stream, "unguarded", stream)
    return inner


def as_typed(words: Sequence[str]) -> list[str]:
    """Decode UTF-8 arguments in a locale without UTF-8 (LC_ALL=C).

    Python decodes such bytes to lone surrogates, which YAML and JSON refuse.
    """
    found = []
    for word in words:
        try:
            found.append(word.encode("utf-8", "surrogateescape").decode("utf-8"))
        except UnicodeError:
            found.append(word)  # not UTF-8: unchanged
    return found


def _readable(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    if error.object[error.start] not in _READABLE:
        one = UnicodeEncodeError(error.encoding, error.object, error.start, error.start + 1, error.reason)
        return codecs.backslashreplace_errors(one)
    return _READABLE[error.object[error.start]], error.start + 1


_NOT_ASCII = re.compile(r"[^\x00-\x7e]+")


def json_text(
    value: object, *, ascii_only: bool = False, indent: int | None = None, allow_nan: bool = True
) -> str:
    """`json.dumps` with letters unescaped and unprintable characters as `\\u202e`.

    Args:
        value: See `json.dumps`.
        ascii_only: Escape non-ASCII characters.
        indent, allow_nan: See `json.dumps`.
    """
    text = json.dumps(value, ensure_ascii=ascii_only, indent=indent, allow_nan=allow_nan)
    return text if text.isprintable() else _NOT_ASCII.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    return "".join(c if c.isprintable() or c == "\u3000" else json.dumps(c)[1:-1] for c in found[0])


def warn(text: str) -> None:
    """Print a warning on stderr."""
    print(printable(f"WARNING: {text}"), file=sys.stderr, flush=True)


def counted(number: int, thing: str, things: str | None = None) -> Sentence:
    """Return the number with its noun in singular or plural.

    Args:
        number: The count.
        thing: Singular: "message".
        things: Plural, if irregular: "retries".
    """
    noun = thing if number == 1 else things or thing + "s"
    return say("{number} {noun}", number=number, noun=say(noun))
