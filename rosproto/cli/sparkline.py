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


def plot(values: Sequence[float], *, width: int = 60, height: int = 8) -> str:
    """A curve in Braille dots, two columns and four rows a character, with its range at the left."""
    finite = [v for v in values if math.isfinite(v)]
    if not finite:
        return "(no finite values yet)"
    low, high = min(finite), max(finite)
    span = (high - low) or 1.0
    shown = list(values)[-2 * width :]
    cells = [[0] * width for _ in range(height)]
    for x, value in enumerate(shown):
        if math.isfinite(value):
            y = round((high - value) / span * (4 * height - 1))
            cells[y // 4][x // 2] |= DOTS[y % 4][x % 2]
    labels = [f"{high:.4g}", *[""] * (height - 2), f"{low:.4g}"] if height > 1 else [f"{high:.4g}"]
    margin = max(len(label) for label in labels)
    return "\n".join(
        f"{label:>{margin}} ┤{''.join(chr(0x2800 + bits) for bits in row)}"
        for label, row in zip(labels, cells, strict=True)
    )


def _averaged(values: Sequence[float], width: int) -> list[float]:
    edges = [i * len(values) // width for i in range(width + 1)]
    groups = [values[a:b] for a, b in pairwise(edges)]
    return [math.fsum(group) / len(group) for group in groups]
