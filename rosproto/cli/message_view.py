"""Messages with arrays told by size and strings left out, for people who look at large ones."""

from __future__ import annotations

from typing import Any

from rosproto.codec.message import Message

__all__ = ["Abbreviation"]


class Abbreviation:
    """What --noarr and --nostr make of a value; the value itself is not changed.

    Args:
        no_arrays: An array becomes `<array type: float32, length: 1080>`, as rostopic writes it.
        no_strings: A string becomes `<string length: 5>`.
    """

    def __init__(self, *, no_arrays: bool = False, no_strings: bool = False) -> None:
        self._no_arrays = no_arrays
        self._no_strings = no_strings

    def __call__(self, value: Any) -> Any:
        """The value to print."""
        if not (self._no_arrays or self._no_strings) or not isinstance(value, Message):
            return value
        copy = object.__new__(type(value))
        for name, kind in zip(value.__slots__, value._slot_types, strict=True):
            setattr(copy, name, self._field(getattr(value, name), kind))
        return copy

    def _field(self, value: Any, kind: str) -> Any:
        base, bracket, _ = kind.partition("[")
        if bracket and self._no_arrays:
            return _Words(f"<array type: {base}, length: {len(value)}>")
        if base == "string" and self._no_strings:
            total = len(value) if not bracket else sum(map(len, value))
            return _Words(f"<string length: {total}>")
        if isinstance(value, list):
            return [self(item) for item in value]
        return self(value)


class _Words:
    """Text that prints as it is, without the quotes of a string."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __str__(self) -> str:
        return f'"{self._text}"'
