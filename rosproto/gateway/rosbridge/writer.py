"""Generates, for one message type, the function that turns its messages into JSON text or CBOR values.

As in `rosproto.codec`, the source consists only of words from this package and of field names that
`layout.resolve` has checked; values never become source. There is one function for each type, nested types
included.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from rosproto.codec.layout import FieldLayout, Layout
from rosproto.codec.source import Source

__all__ = ["Writer"]

MOST_PIECES = 200
"""The most fields in one expression; a definition from the network may have tens of thousands."""


class Writer(ABC):
    """Generates `write(message)` for a layout and for those inside it.

    Args:
        leaves: The functions that the expressions of `one` and `many` call, by name.
    """

    def __init__(self, leaves: dict[str, Any]) -> None:
        self._leaves = leaves
        self._made: dict[str, Callable[[Any], Any]] = {}

    def function(self, layout: Layout) -> Callable[[Any], Any]:
        """The function for a message of this layout."""
        found = self._made.get(layout.spec.name)
        if found is None:
            found = self._made[layout.spec.name] = self._make(layout)
        return found

    def _make(self, layout: Layout) -> Callable[[Any], Any]:
        src = Source("def write(m):")
        src.globals.update(self._leaves)
        names = []
        for start in range(0, max(1, len(layout.fields)), MOST_PIECES):
            pieces = []
            for field in layout.fields[start : start + MOST_PIECES]:
                value = src.fresh("x")
                src.line(f"{value} = m.{field.attr}")
                pieces.append((field.name, self._field(src, field, value)))
            name = src.fresh("p")
            src.line(f"{name} = {self.run(pieces, first=start == 0)}")
            names.append(name)
        src.line(f"return {self.join(names)}")
        return src.compile("write", layout.spec.name)

    def _field(self, src: Source, field: FieldLayout, value: str) -> str:
        if field.layout is None:
            return self.many(field, value) if field.is_array else self.one(field, value)
        call = src.constant(self.function(field.layout), "f")
        return self.messages(call, value) if field.is_array else f"{call}({value})"

    # -- what a kind of writer says

    @abstractmethod
    def run(self, pieces: list[tuple[str, str]], *, first: bool) -> str:
        """The expression for several fields; each piece is (name, expression)."""
        ...

    @abstractmethod
    def join(self, names: list[str]) -> str:
        """The expression for a message whose runs of fields are in these variables."""
        ...

    @abstractmethod
    def one(self, field: FieldLayout, value: str) -> str:
        """The expression for a number, string or time."""
        ...

    @abstractmethod
    def many(self, field: FieldLayout, value: str) -> str:
        """The expression for an array of them."""
        ...

    @abstractmethod
    def messages(self, call: str, value: str) -> str:
        """The expression for an array of messages, each written by `call`."""
        ...
