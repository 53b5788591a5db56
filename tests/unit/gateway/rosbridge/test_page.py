"""docs/rosbridge.md has every operation with its fields, and the limits that are in force."""

from __future__ import annotations

import re
from pathlib import Path

from rosproto.gateway.rosbridge.fragments import MAX_SENT
from rosproto.gateway.rosbridge.operations import OPERATIONS, RECEIVED_PARTS

PAGE = (Path(__file__).resolve().parents[4] / "docs" / "rosbridge.md").read_text("utf-8")
ROWS = {
    op: re.findall(r"`(\w+)`(\*?)", fields)
    for op, fields in re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE, re.MULTILINE)
}


def test_every_operation_has_its_row() -> None:
    """In the order of the table, each field with its star where it is required."""
    rows = {op: fields for op, fields in ROWS.items() if op not in (*RECEIVED_PARTS, "op")}
    assert rows == {
        op: [(field.name, "*" * field.required) for field in row.fields] for op, row in OPERATIONS.items()
    }
    assert set(RECEIVED_PARTS) <= set(ROWS)


def test_the_figures() -> None:
    """What the page says of fragments holds."""
    assert f"in fragments, at most {MAX_SENT} of them" in PAGE
