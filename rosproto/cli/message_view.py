"""Messages with arrays told by size, strings left out, or times as offsets, for people who look at them."""

from __future__ import annotations

from typing import Any

from rosproto.codec.message import Message
from rosproto.time import Time

__all__ = ["View"]


class View:
    """What --noarr, --nostr and --offset make of a value; the value itself is not changed.

    Args:
        no_arrays: An array becomes `<array type: float32, length: 1080>`, as rostopic writes it.
        no_strings: A string becomes `<string length: 5>`.
        since: Times become durations since this one; None leaves them.
    """

    def __init__(
        self, *, no_arrays: bool = False, no_strings: bool = False, since: Time | None = None
    ) -> None:
        self._no_arrays = no_arrays
        self._no_strings = no_strings
        self.since = since

    def __call__(self, value: Any) -> Any:
        """The value to print."""
        if isinstance(value, Time) and self.since is not None:
            return value - self.since
        if not (self._no_arrays or self._no_strings or self.since) or not isinstance(value, Message):
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
