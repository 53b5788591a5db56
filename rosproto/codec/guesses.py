"""Guesses about string lengths, with which many strings are read by one struct.

Messages of a type mostly have strings of the lengths that the last ones had: frame ids do not change. The
decoder guesses so, reads everything at once, and compares; where a guess is wrong it decodes in steps.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from rosproto.codec.layout import Layout
from rosproto.codec.source import quickest

__all__ = ["flat_codes", "iterators", "length_offsets", "sizes", "strings_inside"]

LEARN_AT_MOST = 4096
"""Messages of unforeseen lengths after which a type is taken for one whose lengths never repeat."""
LEARN_SIZES = 8192
"""Bytes of a message up to which the struct for its size is remembered."""


def flat_codes(layout: Layout) -> list[str]:
    codes: list[str] = []
    for field in layout.fields:
        if field.is_array:
            codes.append(f"{field.min_size}x")
        elif field.kind == "string":
            codes.extend(("I", "%ds"))
        elif field.layout is not None:
            codes.extend(flat_codes(field.layout))
        else:
            codes.extend(field.code)
    return codes


def length_offsets(codes: list[str]) -> list[int]:
    """Where each string's length stands, not counting the strings before it."""
    offsets, position = [], 0
    for code, following in zip(codes, [*codes[1:], ""], strict=True):
        if following == "%ds":
            offsets.append(position)
        if code != "%ds":
            position += struct.calcsize("<" + code)
    return offsets


def strings_inside(layout: Layout, *, views: bool = False) -> int | None:
    """How many strings a message of numbers, times and strings has; None when it holds an array.

    With `views`, arrays of numbers of fixed length are no hindrance.
    """
    total = 0
    for field in layout.fields:
        if field.is_array and views and field.kind == "number" and field.length:
            continue
        if field.is_array:
            return None
        if field.kind == "string":
            total += 1
        elif field.layout is not None:
            inner = strings_inside(field.layout, views=views)
            if inner is None:
                return None
            total += inner
    return total


def iterators(form: str) -> Callable[[Any], Any]:
    """`iter_unpack` for given string lengths; remembers a few."""
    known: dict[Any, Any] = {}

    def iterator(lengths: Any) -> Any:
        found = known.get(lengths)
        if found is None:
            if len(known) >= 64:
                known.clear()
            found = known[lengths] = struct.Struct(quickest(form % lengths, packs=False)).iter_unpack
        return found

    return iterator


def sizes(form: str) -> tuple[Callable[[int], Any], Callable[[int, tuple[int, ...]], None]]:
    """Remembers for sizes of messages the struct that read the last one of that size.

    Gives `get(size)` and `learn(size, lengths)`. Where lengths never repeat it gives up.
    """
    known: dict[int, Any] = {}
    learned = 0

    def learn(size: int, lengths: tuple[int, ...]) -> None:
        nonlocal learned
        learned += 1
        if learned > LEARN_AT_MOST:
            known.clear()
        elif size <= LEARN_SIZES and len(known) < 512:
            known[size] = struct.Struct(quickest(form % lengths, packs=False)).unpack_from

    return known.get, learn
