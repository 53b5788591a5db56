"""JSON that clients send, bounded before it is decoded.

Python decodes a text in one piece, and no other thread of the process runs meanwhile: not the one that sends
zero for a client that has fallen silent either. What it takes grows with the values and keys of the text, up
to a microsecond for each, not with its length. So these are counted first, and of all clients' long texts one
is decoded at a time.
"""

from __future__ import annotations

import json
import re
import sys
import threading
from collections.abc import Callable
from typing import Any

SHORT = 16 << 10
SHORT_VALUES = 2000
"""A text of so many characters and values is decoded in two milliseconds at most."""


class JsonError(ValueError):
    """The text is no JSON, or too much of it; says what it is, after "the message"."""


def is_short(text: str | bytes) -> bool:
    """Whether decoding a text takes no time worth a thread."""
    return len(text) <= SHORT and _values_in(text) <= SHORT_VALUES


def _values_in(text: str | bytes) -> int:
    """At least the number of values and keys of a text: the signs inside its strings count, too."""
    if isinstance(text, str):
        return 1 + sum(map(text.count, ",[{:"))
    return 1 + sum(map(text.count, (b",", b"[", b"{", b":")))


def _short_int(digits: str) -> int:
    """As Python does by itself from 3.10.7 on: a million digits would take minutes."""
    if len(digits) > 4300:
        raise ValueError("too many digits")
    return int(digits)


_decoder = json.JSONDecoder(parse_int=None if hasattr(sys, "get_int_max_str_digits") else _short_int)
_blanks: Callable[[str, int], re.Match[str]] = re.compile(r"[ \t\n\r]*").match  # type: ignore[assignment]


class JsonReader:
    """Reads the texts of all clients of a gateway; from any thread.

    Args:
        most_values: Values and keys of one text.
        nesting: Arrays and objects inside one another.
    """

    def __init__(self, most_values: int, nesting: int) -> None:
        self._most_values = most_values
        self._nesting = nesting
        self._turn = threading.Lock()

    def read(self, text: str | bytes, most: int = 1) -> list[Any]:
        """The values that stand behind one another in a text; none where it is empty.

        Args:
            text: The text; bytes are taken for UTF-8.
            most: How many there may be.

        Raises:
            JsonError: It is no JSON, or too much.
        """
        if not isinstance(text, str):
            try:
                text = text.decode("utf-8")
            except UnicodeDecodeError as error:
                raise JsonError(f"is no UTF-8 text: {error.reason} at byte {error.start}") from None
        values = _values_in(text)
        if values > self._most_values:
            raise JsonError(
                f"has {values} values and keys, and at most {self._most_values} are taken; a gateway that is "
                "started with a larger --message-bytes takes one for every ten bytes of it"
            )
        if len(text) <= SHORT and values <= SHORT_VALUES:
            return self._decoded(text, most, values)
        with self._turn:
            return self._decoded(text, most, values)

    def _decoded(self, text: str, most: int, values: int) -> list[Any]:
        found: list[Any] = []
        at, end = 0, len(text.rstrip())
        try:
            while at < end:
                if len(found) == most:
                    raise JsonError(f"is more than {most} at once; send them one by one")
                value, at = _decoder.raw_decode(text, _blanks(text, at).end())
                if values > self._nesting:
                    self._check_nesting(value)
                found.append(value)
        except RecursionError:
            raise self._too_deep() from None
        except JsonError:
            raise
        except ValueError as error:
            raise JsonError(f"is no JSON: {_in_short(error)}") from None
        return found

    def _check_nesting(self, value: Any) -> None:
        level: list[Any] = [value]
        for _ in range(self._nesting):
            level = [
                inner
                for outer in level
                if type(outer) is dict or type(outer) is list
                for inner in (outer.values() if type(outer) is dict else outer)
                if type(inner) is dict or type(inner) is list
            ]
            if not level:
                return
        raise self._too_deep()

    def _too_deep(self) -> JsonError:
        return JsonError(f"has more than {self._nesting} arrays and objects inside one another")


def _in_short(error: ValueError) -> str:
    """What the decoder says and where, without the text it quotes."""
    if isinstance(error, json.JSONDecodeError):
        return f"{error.msg} at character {error.pos}"
    return "a number has too many digits"
