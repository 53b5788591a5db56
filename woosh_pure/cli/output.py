"""Prints a command's results: lines for people, JSON for programs, a progress line during long waits.

An exception has its own exit code: `exit_code` in `rosproto/errors.py` and `woosh_pure/errors.py`. A command
without an exception returns a code from here.
"""

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

from rosproto.cli import (
    DONE,
    FAILED,
    INTERRUPTED,
    TERMINATED,
    UNREACHABLE,
    WRONG_USE,
    Progress,
    enable_escapes,
    is_terminal,
    json_text,
    own,
)
from rosproto.sentence import say
from rosproto.text import padded, printable

REFUSED, NOT_KNOWN = 3, 5
EXIT_CODES = {
    DONE: "done",
    FAILED: "it failed, or the answer is no; one sentence on stderr says why and what to do",
    WRONG_USE: "wrong use: an argument is missing, unknown or out of range; nothing was sent",
    REFUSED: "the chassis is not ready, or refused to move",
    UNREACHABLE: "the chassis cannot be reached, or the connection was lost",
    NOT_KNOWN: "the answer is not known: the chassis has not told it (`ready`, `faults`)",
    INTERRUPTED: "interrupted by Ctrl-C; a motion of this command was stopped",
    TERMINATED: "ended by SIGTERM, a hang-up or a closed console; a motion of this command was stopped",
}
"""What the exit codes mean."""
READY = {"yes": DONE, "no": REFUSED, "not known": NOT_KNOWN}
"""Exit codes of `woosh ready`, by its answer."""
_COLOURS = {"red": "31", "green": "32", "yellow": "33", "blue": "34", "bold": "1", "dim": "2"}
_FIRST_SIGN = 1.0


class Output:
    """The output of a command.

    Attributes:
        as_json: True when only `result` and `record` may print on stdout.
        language: Language of the lines, see `woosh_pure.language`; JSON is the same in each.
        coloured: True when stdout is a terminal that shows colours, and $NO_COLOR is not set.
    """

    def __init__(self, *, as_json: bool = False, stream: TextIO | None = None, language: str = "en") -> None:
        self.as_json = as_json
        self.language = language
        self._stream = stream or sys.stdout
        self._said = False
        self._mark = f"\x1b{os.urandom(8).hex()}"
        self.coloured = not as_json and not os.environ.get("NO_COLOR") and enable_escapes(self._stream)

    def line(self, *cells: str, **values: Any) -> None:
        """Print a line for people and flush; silent with --json.

        Control characters and line ends are escaped, except the colours of `colour`.

        Args:
            cells: Sentences, or results of `cell` and `colour`; joined by blanks.
            values: Of the template of a sentence, the only cell; see `rosproto.sentence.say`.
        """
        if not self.as_json:
            cells = (say(*cells, **values),) if values else cells
            self._write(self._shown(" ".join(map(self.say, cells))))

    def say(self, text: str) -> str:
        """Translate a text to the output's language; unknown texts stay English."""
        return spoken(text, self.language)

    def cell(self, text: str, width: int) -> str:
        """Translate a text and pad it to the column's width."""
        return padded(self.say(text), width)

    def colour(self, text: str, name: str, width: int = 0) -> str:
        """Return a coloured cell; plain without colours."""
        text = self.cell(text, width)
        return f"{self._mark}[{_COLOURS[name]}m{text}{self._mark}[0m" if self.coloured else text

    def _shown(self, text: str) -> str:
        """Escape all but the marks of `colour`, which peers do not know."""
        if not self.coloured:
            return printable(text)
        first, *rest = text.split(self._mark)
        parts = [part.partition("m") for part in rest]
        return printable(first) + "".join(f"\x1b{code}m{printable(more)}" for code, _, more in parts)

    def result(self, value: Any) -> None:
        """Print the JSON document; silent without --json."""
        if self.as_json:
            self._said = True
            self._write(json_text(plain(value), indent=2, allow_nan=False))

    def record(self, value: Any) -> None:
        """Print one of many JSON documents, a line each (JSON Lines); silent without --json."""
        if self.as_json:
            self._said = True
            self._write(json_text(plain(value), allow_nan=False))

    def failure(self, text: str, code: int) -> None:
        """Print the JSON document of a failed command, unless it has printed one."""
        if not self._said:
            self.result({"ok": False, "error": text, "exit_code": code})

    @contextmanager
    def working(self, what: str) -> Iterator[None]:
        """Show progress on stderr after one second.

        On a terminal, one line counts the seconds; elsewhere it is a single line.
        """
        done = threading.Event()
        what = self.say(what)
        thread = threading.Thread(target=_show_life, args=(what, done), name="woosh:progress", daemon=True)
        if not self.as_json:
            try:
                thread.start()
            except RuntimeError:
                pass  # no thread can be started: a stop must not fail for missing output
        try:
            yield
        finally:
            done.set()
            if thread.is_alive():
                thread.join(1.0)

    def _write(self, text: str) -> None:
        print(text, file=own(self._stream), flush=True)


def spoken(text: str, language: str) -> str:
    """Translate a text to a language of `woosh_pure.language`."""
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
        return  # the reader has gone


def plain(value: Any) -> Any:
    """Convert a value for JSON: dataclasses to objects, arrays to lists, enums to names, NaN to null."""
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "__dataclass_fields__"):  # without the slow import of dataclasses
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
    """Use the terminal's alternate screen without a cursor within the block; always restore it."""
    own(stream).write("\x1b[?1049h\x1b[?25l\x1b[2J")
    stream.flush()
    try:
        yield
    finally:
        own(stream).write("\x1b[?25h\x1b[?1049l")
        stream.flush()
