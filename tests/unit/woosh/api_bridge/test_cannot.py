"""What a robot with only the Robot API cannot express: one table, for the tests and for the page."""

from __future__ import annotations

from pathlib import Path

from tests.support.through_robot_api import CANNOT, SKIPPED

PAGE = Path(__file__).resolve().parents[4] / "docs" / "robot-api.md"


def test_the_page_has_the_rows_of_the_table() -> None:
    section = PAGE.read_text("utf-8").partition("What it cannot express is missing")[2]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line.startswith("| ")]
    assert dict(rows[1:]) == CANNOT


def test_each_skipped_test_names_a_row() -> None:
    assert set(SKIPPED.values()) <= set(CANNOT)
