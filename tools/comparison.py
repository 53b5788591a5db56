"""`python -m tools.comparison` writes the tables of docs/comparison.md and of its Chinese twin.

`comparison_clients.csv` and `comparison_servers.csv` have a row for each feature: its name in both languages,
the answers of all columns (Y, P, N; "-" does not apply, "?" is not known to us), what a P of ours means, and
the tests that hold our answer, below `tests`. `tests/unit/tools/test_comparison.py` sees that the pages are
those that this makes, and that no claim of ours is without tests.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = {"en": ROOT / "docs/comparison.md", "zh": ROOT / "docs/comparison.zh-CN.md"}
NAMES = ("clients", "servers")
"""The tables, in the order of the page."""


def read(name: str) -> tuple[list[str], list[dict[str, str]]]:
    """The products that a table compares, ours first, and its rows by title."""
    with (ROOT / f"tools/comparison_{name}.csv").open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
        return list(reader.fieldnames or ())[2:-3], rows


def table(name: str, language: str) -> Iterator[str]:
    """The lines of a table in Markdown."""
    products, rows = read(name)
    yield f"| | {' | '.join(products)} |"
    yield "|" + "---|" * (len(products) + 1)
    for row in rows:
        ours, *others = (row[product] for product in products)
        ours = "**N**" if ours == "N" else ours
        if language == "en":
            title, ours = row["feature"], f"{ours} ({row['note']})" if row["note"] else ours
        else:
            title, ours = row["功能"], f"{ours}（{row['说明']}）" if row["说明"] else ours
        yield f"| {' | '.join([title, ours, *others])} |"


def page(text: str, language: str) -> str:
    """The page with its tables renewed."""
    tables = iter("\n".join(table(name, language)) + "\n" for name in NAMES)
    text, count = re.subn(r"^\| \|.*\n(?:\|.*\n)*", lambda _: next(tables), text, flags=re.MULTILINE)
    if count != len(NAMES):
        raise SystemExit(f"the page has {count} tables that begin with an empty cell, not {len(NAMES)}")
    return text


if __name__ == "__main__":
    for language, path in PAGES.items():
        path.write_text(page(path.read_text("utf-8"), language), "utf-8", newline="\n")
