"""A message as one line of comma-separated values, with the column names of `rostopic echo -p`."""

from __future__ import annotations

from typing import Any

from rosproto.codec import Message
from rosproto.text import printable
from rosproto.time import TVal

__all__ = ["header", "row"]


def header(value: Any, prefix: str) -> str:
    """Column names: `field.pose.position.x`, and `field.ranges0,field.ranges1` for arrays."""
    return ",".join(_names(value, prefix))


def row(value: Any, *, one_line: bool = False) -> str:
    """The values, in the order of `header`; times in nanoseconds, bools 0 and 1.

    Args:
        value: A message, or what a field of one holds.
        one_line: Escape what a terminal would obey, and line ends; else a text is what it is, in quotes.
    """
    cells = _cells(value)
    return ",".join(map(printable, cells) if one_line else cells)


def _items(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _names(value: Any, prefix: str) -> list[str]:
    value = _items(value)
    if isinstance(value, Message):
        return [n for f in value.__slots__ for n in _names(getattr(value, f), f"{prefix}.{f}")]
    if isinstance(value, (list, tuple, bytes)):
        return [n for i, item in enumerate(value) for n in _names(item, f"{prefix}{i}")]
    return [prefix]


def _cells(value: Any) -> list[str]:
    value = _items(value)
    if isinstance(value, Message):
        return [cell for f in value.__slots__ for cell in _cells(getattr(value, f))]
    if isinstance(value, (list, tuple, bytes)):
        return [cell for item in value for cell in _cells(item)]
    if isinstance(value, bool):
        return ["1" if value else "0"]
    if isinstance(value, TVal):
        return [str(value.to_nsec())]
    if isinstance(value, str) and any(c in value for c in ',"\n\r'):
        return ['"' + value.replace('"', '""') + '"']
    return [str(value)]
