"""A row of values as a line of small bars, and a plot of several lines: for terminals, without curses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

__all__ = ["plot", "sparkline"]

BARS = "▁▂▃▄▅▆▇█"
ASCII_BARS = "_.-=+*%#"
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of a Braille cell (U+2800 block), by row and column."""


def sparkline(values: Sequence[float], *, width: int | None = None, ascii_only: bool = False) -> str:
    """One character a value, low to high; NaN is a space.

    Args:
        values: Any finite range; all equal gives the lowest bar.
        width: At most this many characters: neighbours are averaged.
        ascii_only: For terminals whose encoding lacks block characters.
    """
    values = list(values) if width is None or len(values) <= width else _averaged(values, width)
    finite = [v for v in values if math.isfinite(v)]
    if not finite:
        return " " * len(values)
    low, span = min(finite), max(finite) - min(finite)
    bars = ASCII_BARS if ascii_only else BARS
    top = len(bars) - 1
    return "".join(
        " " if not math.isfinite(v) else bars[0 if span == 0 else round((v - low) / span * top)]
        for v in values
    )


def plot(values: Sequence[float], *, width: int = 60, height: int = 8, ascii_only: bool = False) -> str:
    """A curve in Braille dots, two columns and four rows a character, with its range at the left.

    Args:
        values: The newest that fit are shown: two a character, one in ASCII.
        width: Characters of the whole line, with the range.
        height: Lines.
        ascii_only: For terminals that lack Braille: stars, one a value.
    """
    values = list(values)[-(1 if ascii_only else 2) * width :]
    finite = [v for v in values if math.isfinite(v)]
    if not finite:
        return "(no finite values yet)"
    low, high = min(finite), max(finite)
    span = (high - low) or 1.0
    labels = [f"{high:.4g}", *[""] * (height - 2), f"{low:.4g}"] if height > 1 else [f"{high:.4g}"]
    margin = max(len(label) for label in labels)
    columns = max(1, width - margin - 2)
    draw = _stars if ascii_only else _braille
    rows = draw([(high - v) / span for v in values], columns, height)
    axis = "|" if ascii_only else "┤"
    return "\n".join(f"{label:>{margin}} {axis}{row}" for label, row in zip(labels, rows, strict=True))


def _braille(depths: Sequence[float], columns: int, height: int) -> list[str]:
    """Lines of dots; a depth is 0 at the top and 1 at the bottom."""
    cells = [[0] * columns for _ in range(height)]
    for x, depth in enumerate(depths[-2 * columns :]):
        if math.isfinite(depth):
            y = round(depth * (4 * height - 1))
            cells[y // 4][x // 2] |= DOTS[y % 4][x % 2]
    return ["".join(chr(0x2800 + bits) for bits in row) for row in cells]


def _stars(depths: Sequence[float], columns: int, height: int) -> list[str]:
    cells = [[" "] * columns for _ in range(height)]
    for x, depth in enumerate(depths[-columns:]):
        if math.isfinite(depth):
            cells[round(depth * (height - 1))][x] = "*"
    return ["".join(row).rstrip() for row in cells]


def _averaged(values: Sequence[float], width: int) -> list[float]:
    edges = [i * len(values) // width for i in range(width + 1)]
    groups = [values[a:b] for a, b in pairwise(edges)]
    return [math.fsum(group) / len(group) for group in groups]
