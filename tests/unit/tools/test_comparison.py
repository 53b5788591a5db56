"""The comparison says what tests hold: no claim without one, and the pages are those that the table makes."""

from __future__ import annotations

import pytest

from tools.comparison import NAMES, PAGES, ROOT, page, read


@pytest.mark.parametrize("language", PAGES)
def test_the_committed_pages_are_current(language: str) -> None:
    """Whoever changes a table runs `python -m tools.comparison`."""
    text = PAGES[language].read_text("utf-8")
    assert page(text, language) == text


@pytest.mark.parametrize("name", NAMES)
def test_each_claim_of_ours_names_tests_that_exist_and_each_cell_has_an_answer(name: str) -> None:
    products, rows = read(name)
    assert products[0] == "woosh-pure"
    assert len(rows) == len({row["feature"] for row in rows}) > 10
    for row in rows:
        ours = row["woosh-pure"]
        assert ours in {"Y", "P", "N"}, row
        assert {row[product] for product in products} <= set("YPN-?"), row
        assert bool(row["tests"]) == (ours != "N"), row
        assert bool(row["note"]) == bool(row["说明"]) == (ours == "P"), row
        for path in row["tests"].split():
            assert (ROOT / "tests" / path).exists(), row
