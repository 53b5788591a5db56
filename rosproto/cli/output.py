"""Prints a command's results: lines for people, JSON for programs, a progress line during long waits.

Both commands print by it: `rosproto` in English, `woosh` in a language. An exception has its own exit code:
`exit_code` in `rosproto/errors.py` and `woosh_pure/errors.py`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from typing import TextIO

from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import enable_escapes, json_text, own, shows_unicode
from rosproto.json_values import plain
from rosproto.sentence import say
from rosproto.text import padded, printable

_COLOURS = {"red": "31", "green": "32", "yellow": "33", "blue": "34", "bold": "1", "dim": "2"}


class Output:
    """The output of a command.

    Attributes:
        as_json: True when only `result` and `record` may print on stdout.
        say: Translates a text to the language of the lines; JSON is the same in each.
        coloured: True when stdout is a terminal that shows colours, and $NO_COLOR is not set.
    """

    def __init__(
        self,
        *,
        as_json: bool = False,
        stream: TextIO | None = None,
        translate: Callable[[str], str] = lambda text: text,
    ) -> None:
        self.as_json = as_json
        self.say = translate
        self._stream = stream or sys.stdout
        self._said = False
        self._mark = f"\x1b{os.urandom(8).hex()}"
        self.coloured = not as_json and not os.environ.get("NO_COLOR") and enable_escapes(self._stream)

    def line(self, *cells: str, **values: object) -> None:
        """Print a line for people and flush; silent with --json.

        Control characters and line ends are escaped, except the colours of `colour`.

        Args:
            cells: Sentences, or results of `cell` and `colour`; joined by blanks.
            values: Of the template of a sentence, the only cell; see `rosproto.sentence.say`.
        """
        if not self.as_json:
            cells = (say(*cells, **values),) if values else cells
            self._write(self._shown(" ".join(map(self.say, cells))))

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

    def result(self, value: object) -> None:
        """Print the JSON document; silent without --json."""
        if self.as_json:
            self._document(plain(value), indent=2)

    def record(self, value: object, *, is_plain: bool = False) -> None:
        """Print a JSON document in one line (many are JSON Lines); silent without --json.

        Args:
            value: See `rosproto.json_values.plain`.
            is_plain: It consists of JSON's own types, with finite numbers.
        """
        if self.as_json:
            self._document(value if is_plain else plain(value))

    def answer(self, value: object, lines: str | Iterable[str]) -> None:
        """Print the result of a verb: with --json the value in one line, else the lines."""
        if self.as_json:
            self.record(value)
        elif text := [lines] if isinstance(lines, str) else list(lines):
            print("\n".join(text), file=self._stream, flush=True)

    def _document(self, value: object, indent: int | None = None) -> None:
        self._said = True
        # A letter that the encoding lacks would become another one. A stream without an encoding lacks none.
        ascii_only = bool(getattr(self._stream, "encoding", "")) and not shows_unicode(self._stream)
        self._write(json_text(value, ascii_only=ascii_only, indent=indent, allow_nan=False))

    def failure(self, text: str, code: int) -> None:
        """Print the JSON document of a failed command, unless it has printed one."""
        if not self._said:
            self.result({"ok": False, "error": text, "exit_code": code})

    def working(self, what: str) -> Progress:
        """Show progress on stderr after one second, in a `with` block; nothing with --json.

        On a terminal, one line counts the seconds; elsewhere it is a single line.
        """
        return Progress(self.say(what), quiet=self.as_json, announced=True)

    def _write(self, text: str) -> None:
        print(text, file=own(self._stream), flush=True)
