"""Prints a command's results: lines for people, JSON for programs, and a progress line during long waits."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from typing import Any, TextIO

from rosproto.cli import Progress, enable_escapes, is_terminal, json_text, own
from rosproto.text import padded, printable

_COLOURS = {"red": "31", "green": "32", "yellow": "33", "blue": "34", "bold": "1", "dim": "2"}
_FIRST_SIGN = 1.0


class Output:
    """Where a command prints.

    Attributes:
        as_json: True when only `result` and `record` may print on stdout.
        language: Of the lines for people, see `woosh_pure.language`; the documents are the same in each.
        coloured: True when stdout is a terminal that shows colours, and $NO_COLOR is not set.
    """

    def __init__(self, *, as_json: bool = False, stream: TextIO | None = None, language: str = "en") -> None:
        self.as_json = as_json
        self.language = language
        self._stream = stream or sys.stdout
        self._said = False
        self._mark = f"\x1b{os.urandom(8).hex()}"
        self.coloured = not as_json and not os.environ.get("NO_COLOR") and enable_escapes(self._stream)

    def line(self, *cells: str) -> None:
        """A line for people, at once visible; silent with --json.

        One line, whatever peers have put into it: of controls only the colours of `colour` remain.

        Args:
            cells: Sentences, or what `cell` and `colour` have made, a blank between them.
        """
        if not self.as_json:
            self._write(self._shown(" ".join(map(self.say, cells))))

    def say(self, text: str) -> str:
        """The text in the language of this output; what its table does not have stays English."""
        return spoken(text, self.language)

    def cell(self, text: str, width: int) -> str:
        """A cell of a column: the text in the language of this output, as wide as the column."""
        return padded(self.say(text), width)

    def colour(self, text: str, name: str, width: int = 0) -> str:
        """A cell in a colour of the terminal; without it where there are none."""
        text = self.cell(text, width)
        return f"{self._mark}[{_COLOURS[name]}m{text}{self._mark}[0m" if self.coloured else text

    def _shown(self, text: str) -> str:
        """Escaped, but for what `colour` has marked: no peer knows the mark."""
        if not self.coloured:
            return printable(text)
        first, *rest = text.split(self._mark)
        parts = [part.partition("m") for part in rest]
        return printable(first) + "".join(f"\x1b{code}m{printable(more)}" for code, _, more in parts)

    def result(self, value: Any) -> None:
        """The document for machines; silent without --json."""
        if self.as_json:
            self._said = True
            self._write(json_text(plain(value), indent=2, allow_nan=False))

    def record(self, value: Any) -> None:
        """One of many documents for machines, a line each (JSON Lines); silent without --json."""
        if self.as_json:
            self._said = True
            self._write(json_text(plain(value), allow_nan=False))

    def failure(self, text: str, code: int) -> None:
        """The document for machines of a command that failed before it had one."""
        if not self._said:
            self.result({"ok": False, "error": text, "exit_code": code})

    @contextmanager
    def working(self, what: str) -> Iterator[None]:
        """Show on stderr that something is going on when it takes longer than a second.

        On a terminal one line that counts; elsewhere a single line.
        """
        done = threading.Event()
        what = self.say(what)
        thread = threading.Thread(target=_show_life, args=(what, done), name="woosh:progress", daemon=True)
        if not self.as_json:
            try:
                thread.start()
            except RuntimeError:
                pass  # no thread can be started: a stop is not to fail for want of words
        try:
            yield
        finally:
            done.set()
            if thread.is_alive():
                thread.join(1.0)

    def _write(self, text: str) -> None:
        try:
            print(text, file=own(self._stream), flush=True)
        except UnicodeEncodeError:  # a Windows console with an old code page
            encoding = self._stream.encoding or "ascii"
            print(text.encode(encoding, "replace").decode(encoding), file=own(self._stream), flush=True)


def spoken(text: str, language: str) -> str:
    """The text in a language of `woosh_pure.language`."""
    if language == "en":
        return text
    from woosh_pure.language.table import translator_for

    return translator_for(language).say(text)


def _show_life(what: str, done: threading.Event) -> None:
    began = time.monotonic()
    if done.wait(_FIRST_SIGN):
        return
    stream = sys.stderr
    try:
        if not is_terminal(stream):
            print(f"{what} ...", file=stream, flush=True)
            return
        with Progress("", stream=stream) as line:
            while not done.wait(0.2):
                line.show(f"{what} ... {time.monotonic() - began:.0f} s ")
    except (OSError, ValueError):
        return  # nobody reads it any more


def plain(value: Any) -> Any:
    """A value as JSON has it: dataclasses as objects, arrays as lists, enums by name, NaN as null."""
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "__dataclass_fields__"):  # without importing dataclasses, which --help would pay for
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    return str(value)


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
