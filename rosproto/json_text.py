"""`JsonReader`: decodes JSON from peers after counting its values.

Decoding a text blocks all other threads, the one that sends zero velocities too. It takes up to a microsecond
for each value and key, whatever the length of the text. They are therefore counted first, and only one long
text of all clients is decoded at a time.
"""

from __future__ import annotations

import json
import re
import sys
import threading
from collections.abc import Callable

from rosproto.json_values import JsonValue

__all__ = ["JsonError", "JsonReader", "is_short"]

SHORT = 16 << 10
SHORT_VALUES = 2000
"""A text with at most this many values is decoded within two milliseconds."""


class JsonError(ValueError):
    """The text is not JSON, or has too many values. The text of the error continues "the message"."""


def is_short(text: str | bytes) -> bool:
    """Whether a text is decoded too fast to be worth a thread."""
    return len(text) <= SHORT and _values_in(text) <= SHORT_VALUES


def _values_in(text: str | bytes) -> int:
    """An upper bound of the number of values and keys: commas and braces inside strings count, too."""
    if isinstance(text, str):
        return 1 + sum(map(text.count, ",[{:"))
    return 1 + sum(map(text.count, (b",", b"[", b"{", b":")))


def _short_int(digits: str) -> int:
    """Refuse numbers with very many digits, as Python 3.10.7 and later do: a million would take minutes."""
    if len(digits) > 4300:
        raise ValueError("too many digits")
    return int(digits)


_decoder = json.JSONDecoder(parse_int=None if hasattr(sys, "get_int_max_str_digits") else _short_int)
_blanks: Callable[[str, int], re.Match[str]] = re.compile(r"[ \t\n\r]*").match  # type: ignore[assignment]


class JsonReader:
    """Reads the texts of all clients of a gateway, or the answers of a robot; from any thread.

    Args:
        max_values: Values and keys of one text.
        nesting: Arrays and objects inside one another.
        remedy: What to do about a text with more values.
    """

    def __init__(self, max_values: int, nesting: int, remedy: str = "") -> None:
        self._max_values = max_values
        self._nesting = nesting
        self._remedy = f"; {remedy}" if remedy else ""
        self._turn = threading.Lock()

    def read(self, text: str | bytes, max_documents: int = 1) -> list[JsonValue]:
        """Return the JSON values of a text, which follow one another; an empty list for an empty text.

        Args:
            text: The text; bytes are taken for UTF-8.
            max_documents: Most documents in the text.

        Raises:
            JsonError: It is not JSON, or has too many values.
        """
        if not isinstance(text, str):
            try:
                text = text.decode("utf-8")
            except UnicodeDecodeError as error:
                raise JsonError(f"is not UTF-8 text: {error.reason} at byte {error.start}") from None
        values = _values_in(text)
        if values > self._max_values:
            raise JsonError(
                f"has {values} values and keys, and at most {self._max_values} are accepted{self._remedy}"
            )
        if len(text) <= SHORT and values <= SHORT_VALUES:
            return self._decoded(text, max_documents, values)
        with self._turn:
            return self._decoded(text, max_documents, values)

    def one(self, text: str | bytes) -> JsonValue:
        """The JSON value of a text, None of an empty one; errors as those of `read`."""
        return next(iter(self.read(text)), None)

    def _decoded(self, text: str, max_documents: int, values: int) -> list[JsonValue]:
        found: list[JsonValue] = []
        at, end = 0, len(text.rstrip())
        try:
            while at < end:
                if len(found) == max_documents:
                    raise JsonError(f"has more than {max_documents} values in a row; send them one by one")
                value, at = _decoder.raw_decode(text, _blanks(text, at).end())
                if values > self._nesting:
                    self._check_nesting(value)
                found.append(value)
        except RecursionError:
            raise self._too_deep() from None
        except JsonError:
            raise
        except ValueError as error:
            raise JsonError(f"is not JSON: {_in_short(error)}") from None
        return found

    def _check_nesting(self, value: JsonValue) -> None:
        level: list[JsonValue] = [value]
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
    """The decoder's message and position, without the quoted text."""
    if isinstance(error, json.JSONDecodeError):
        return f"{error.msg} at character {error.pos}"
    return "a number has too many digits"
