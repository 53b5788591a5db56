"""Several numbers over time as curves in a terminal, with a time axis; no clock, no output of its own."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

__all__ = ["Curves"]

COLOURS = ("36", "33", "32", "35", "31", "34")
SIGNS = "*+ox#@"
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of a Braille cell (U+2800 block), by row and column."""
KEPT = 5000
"""Samples of each curve."""


class Curves:
    """The newest samples of some numbers.

    Args:
        names: Of the curves, in the order of the legend.
        seconds: How far back the picture reaches; None shows all that is kept.
    """

    def __init__(self, names: Sequence[str], seconds: float | None = 30.0) -> None:
        self.names = list(names)
        self._seconds = seconds
        self._samples: list[deque[tuple[float, float]]] = [deque(maxlen=KEPT) for _ in names]

    def add(self, index: int, moment: float, value: float) -> None:
        """A sample of one curve; moment in s."""
        samples = self._samples[index]
        if samples and moment < samples[-1][0]:
            samples.clear()  # a bag or a clock that began again
        samples.append((moment, value))
        while self._seconds is not None and moment - samples[0][0] > self._seconds:
            samples.popleft()

    def legend(self, coloured: bool) -> list[str]:
        """A line for each: its sign or colour, name and newest value."""
        lines = []
        for i, name in enumerate(self.names):
            value = f"{self._samples[i][-1][1]:.6g}" if self._samples[i] else "nothing yet"
            text = f"{SIGNS[i % len(SIGNS)]} {name}  {value}" if len(self.names) > 1 else f"{name}  {value}"
            lines.append(_in_colour(text, i) if coloured and len(self.names) > 1 else text)
        return lines

    def picture(self, width: int, height: int, *, ascii_only: bool = False, coloured: bool = False) -> str:
        """The curves, their range at the left, the time below.

        Args:
            width: Columns of the whole.
            height: Lines of the whole, with the axis.
            ascii_only: Signs instead of Braille dots.
            coloured: A colour for each curve; without, one look for all but the signs of ASCII.
        """
        finite = [(t, v) for samples in self._samples for t, v in samples if math.isfinite(v)]
        if not finite:
            return "(no finite values yet)"
        low, high = min(v for _, v in finite), max(v for _, v in finite)
        newest = max(samples[-1][0] for samples in self._samples if samples)
        oldest = min(samples[0][0] for samples in self._samples if samples)
        if self._seconds is not None:
            oldest = max(oldest, newest - self._seconds)
        rows = max(1, height - 1)
        labels = [f"{high:.4g}", *[""] * (rows - 2), *([f"{low:.4g}"] if rows > 1 else [])]
        margin = max(map(len, labels))
        columns = max(8, width - margin - 2)
        grid = self._drawn(oldest, newest, low, high, columns, rows, ascii_only, coloured)
        bar = "|" if ascii_only else "┤"
        lines = [f"{label:>{margin}} {bar}{line}" for label, line in zip(labels, grid, strict=True)]
        return "\n".join([*lines, " " * (margin + 2) + _axis(newest - oldest, columns)])

    def _drawn(
        self, oldest: float, newest: float, low: float, high: float, columns: int, rows: int,
        ascii_only: bool, coloured: bool,
    ) -> list[str]:  # fmt: skip
        fine_x, fine_y = (1, 1) if ascii_only else (2, 4)
        span_t, span_v = (newest - oldest) or 1.0, (high - low) or 1.0
        cells: list[list[tuple[int, int]]] = [[(0, 0)] * columns for _ in range(rows)]  # bits, curve
        for index, samples in enumerate(self._samples):
            for moment, value in samples:
                if moment < oldest or not math.isfinite(value):
                    continue
                x = round((moment - oldest) / span_t * (columns * fine_x - 1))
                y = round((high - value) / span_v * (rows * fine_y - 1))
                row, column = y // fine_y, x // fine_x
                bit = 1 if ascii_only else DOTS[y % 4][x % 2]
                cells[row][column] = (cells[row][column][0] | bit, index)
        return ["".join(_cell(*cell, ascii_only, coloured) for cell in row).rstrip(" ") for row in cells]


def _cell(bits: int, index: int, ascii_only: bool, coloured: bool) -> str:
    sign = SIGNS[index % len(SIGNS)] if bits else " "
    text = sign if ascii_only else chr(0x2800 + bits)
    return _in_colour(text, index) if coloured and bits else text


def _in_colour(text: str, index: int) -> str:
    return f"\x1b[{COLOURS[index % len(COLOURS)]}m{text}\x1b[0m"


def _axis(seconds: float, columns: int) -> str:
    """`-30 s        -15 s        now`."""
    parts = max(1, min(4, columns // 14))
    line = [" "] * columns
    for i in range(parts + 1):
        text = "now" if i == parts else f"-{seconds * (parts - i) / parts:.3g} s"
        at = min(columns - len(text), max(0, round(i / parts * columns) - (len(text) if i == parts else 0)))
        line[at : at + len(text)] = text
    return "".join(line).rstrip()
