"""Checks of the values in Master and Slave API replies: a peer's word gets a type before anybody uses it.

Peers are not exact: roscpp answers 0 where a list belongs, some masters answer 0/1 for a boolean. What can be
understood is; everything else is RemoteProtocolError, which names the method, the peer and what came.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rosproto.errors import RemoteProtocolError

T = TypeVar("T")


def checked(method: str, uri: str, value: object, convert: Callable[[object], T]) -> T:
    """`convert(value)`, with what came told when it does not fit.

    Raises:
        RemoteProtocolError: `convert` raised TypeError or ValueError.
    """
    try:
        return convert(value)
    except (TypeError, ValueError) as error:
        raise RemoteProtocolError(f"{method} at {uri}: answered {value!r:.80}, expected {error}") from None


def as_str(value: object) -> str:
    """A string."""
    if isinstance(value, str):
        return value
    raise TypeError("a string")


def as_int(value: object) -> int:
    """An integer; a boolean counts."""
    if isinstance(value, int):
        return int(value)
    raise TypeError("an integer")


def int_or_none(value: object) -> int | None:
    """An integer, or None for anything else: for counts that only inform."""
    return int(value) if isinstance(value, int) else None


def as_bool(value: object) -> bool:
    """A boolean; 0 and 1 count."""
    if isinstance(value, int) and value in (0, 1):
        return bool(value)
    raise TypeError("a boolean")


def as_list(value: object) -> list[object]:
    """An array; what several peers send for "nothing" (0, "", false) counts as empty."""
    if isinstance(value, (list, tuple)):
        return list(value)
    if value is None or (isinstance(value, (int, str)) and not value):
        return []
    raise TypeError("an array")


def as_str_list(value: object) -> list[str]:
    """An array of strings."""
    items = as_list(value)
    if all(isinstance(item, str) for item in items):
        return [str(item) for item in items]
    raise TypeError("an array of strings")


def as_pairs(value: object) -> list[tuple[str, str]]:
    """An array of [name, type]."""
    rows = [as_str_list(row) for row in as_list(value)]
    if any(len(row) != 2 for row in rows):
        raise TypeError("an array of [name, type]")
    return [(row[0], row[1]) for row in rows]


def as_rows(value: object) -> dict[str, list[str]]:
    """Rows [name, [node, ...]] of getSystemState."""
    found: dict[str, list[str]] = {}
    for row in as_list(value):
        cells = as_list(row)
        if len(cells) != 2 or not isinstance(cells[0], str):
            raise TypeError("rows [name, [node, ...]]")
        found[cells[0]] = as_str_list(cells[1])
    return found
