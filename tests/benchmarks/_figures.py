"""Figures of a benchmark: medians with their spread, ratios with what they must reach, and rows of a table.

Ratios are taken round by round, so that a busy minute of the computer hits both sides; a figure is the median of the
rounds, and the spread is from the least to the most.
"""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Sequence

__all__ = ["Table", "print_ratio", "ratios", "short", "spread"]


def ratios(ours: Sequence[float], theirs: Sequence[float]) -> list[float]:
    """Round by round."""
    return [a / b for a, b in zip(ours, theirs, strict=True) if b]


def spread(values: Sequence[float]) -> str:
    """As it is printed while a benchmark runs."""
    return f"{statistics.median(values):9.1f} [{min(values):.1f}-{max(values):.1f}]"


def short(values: Sequence[float]) -> str:
    """As it stands in a table: `1.43 (1.02-3.6)`, two digits that count."""
    return f"{_digits(statistics.median(values))} ({_digits(min(values))}-{_digits(max(values))})"


def _digits(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.1f}" if value >= 2 else f"{value:.2f}"


def print_ratio(label: str, values: Sequence[float], must: float, *, more: bool) -> None:
    """A line with the verdict."""
    value = statistics.median(values)
    good = value >= must if more else value <= must
    sign = ">=" if more else "<="
    print(
        f"  {'ok ' if good else 'NO '} {label:36} {value:6.2f} (must {sign} {must};"
        f" {min(values):.2f}-{max(values):.2f})"
    )


class Table:
    """Rows as `docs/performance.md` has them, in the order in which they were measured."""

    def __init__(self, *columns: str) -> None:
        self._columns = columns
        self._rows: dict[str, dict[str, list[str]]] = {}

    def add(self, row: str, column: str, values: Sequence[float]) -> None:
        """A figure; several of one cell stand one behind the other."""
        self._rows.setdefault(row, defaultdict(list))[column].append(short(values))

    def print(self) -> None:
        """In Markdown."""
        if self._rows:
            print("\n| | " + " | ".join(self._columns) + " |")
            print("|---" * (len(self._columns) + 1) + "|")
        for row, cells in self._rows.items():
            print(f"| {row} | " + " | ".join("; ".join(cells[column]) for column in self._columns) + " |")
