"""A row of values as a line of small bars, for terminals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

__all__ = ["sparkline"]

BARS = "▁▂▃▄▅▆▇█"
ASCII_BARS = "_.-=+*%#"


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


def _averaged(values: Sequence[float], width: int) -> list[float]:
    edges = [i * len(values) // width for i in range(width + 1)]
    groups = [values[a:b] for a, b in pairwise(edges)]
    return [math.fsum(group) / len(group) for group in groups]
