"""Guesses about string lengths, with which many strings are read by one struct.

Messages of a type mostly have strings of the lengths that the last ones had: frame ids do not change. The
decoder guesses so, reads everything at once, and compares; where a guess is wrong it decodes in steps.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import repeat
from typing import Any

from rosproto.codec.layout import Layout
from rosproto.codec.source import quickest

__all__ = ["flat_codes", "length_offsets", "sizes", "strings_inside", "structs"]

LEARN_SIZES = 2048
"""Bytes of a message up to which the struct for its size is remembered."""
SIZES_KEPT = 256
"""Sizes remembered for a type: at most half a megabyte of texts."""


def flat_codes(layout: Layout) -> list[str]:
    """struct codes of a message without arrays; a string's are "I" and "%ds"."""
    codes: list[str] = []
    for field in layout.fields:
        if field.kind == "string":
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


def structs(form: str, method: str) -> Callable[[Any], Any]:
    """A method of the struct for given string lengths; remembers a few."""
    known: dict[Any, Any] = {}

    def chosen(lengths: Any) -> Any:
        found = known.get(lengths)
        if found is None:
            if len(known) >= 64:
                known.clear()
            found = known[lengths] = getattr(struct.Struct(quickest(form % lengths, packs=False)), method)
        return found

    return chosen


def sizes(
    form: str, fixed: int, values: int, split: Callable[[Any], Any]
) -> tuple[dict[int, tuple[Any, ...]], Callable[[int, Any], None]]:
    """What is remembered of messages by their sizes, and the function to tell a size to.

    For a size: the `unpack_from` that reads such a message with the run of bytes that holds its strings; that
    run of the last message, and the values in it, all None at first; None; and what `split` gave for the
    lengths of its strings. `form` has one place for the size of the run; `fixed` bytes are around it.
    """
    known: dict[int, tuple[Any, ...]] = {}

    def learn(size: int, lengths: Any) -> None:
        if size <= LEARN_SIZES and len(known) < SIZES_KEPT:
            unpack = struct.Struct(quickest(form % (size - fixed), packs=False)).unpack_from
            known[size] = (unpack, None, *repeat(None, values), None, split(lengths))

    return known, learn
