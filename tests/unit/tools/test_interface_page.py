"""The page of the interface is what the table says, and names no verb that does not exist."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.interface_page import DEFINITIONS, VERBS, how, page
from woosh_pure import Chassis
from woosh_pure.interface import LISTED
from woosh_pure.interface.table import ROWS, row

PAGE = Path(__file__).resolve().parents[3] / "docs" / "interface.md"


def test_the_committed_page_is_current() -> None:
    """Whoever changes the table or a docstring runs `python -m tools.interface_page > docs/interface.md`."""
    assert PAGE.read_text("utf-8") == page()


@pytest.mark.parametrize("verb", VERBS, ids=[verb.name for verb in VERBS])
def test_a_verb_exists_and_its_rows_too(verb: object) -> None:
    """A verb of the page is a method of `Chassis`, and every row behind it is in the table."""
    name, rows, _ = verb  # type: ignore[misc]
    assert callable(getattr(Chassis, name))
    for each in rows:
        assert row(each).name == each


def test_every_row_is_in_the_page_with_a_way_to_reach_it() -> None:
    """No row of the table is left out, and none has an empty cell for how to use it."""
    text = page()
    for each in ROWS:
        assert f"`{each.name}`" in text
        assert how(each).strip("`")


def test_names_of_which_no_more_is_known_are_in_the_page_and_no_rows() -> None:
    """All ten names of the vendor's screenshot are in the page; a likely type is one of the bundled definitions."""
    text = page()
    for each in LISTED:
        assert f"`{each.name}`" in text
        assert each.name not in {found.name for found in ROWS}
        if each.likely_type:
            package, name = each.likely_type.split("/")
            assert [file for file in (DEFINITIONS / package).glob(f"*/{name}.*") if file.suffix != ".py"]
    for name in ("/IO_input", "/amcl_pose", "/avoid_3d_trigger"):
        assert row(name).name == name
    assert sum(each.source == "screenshot" for each in LISTED) == 7


def test_every_row_of_the_vendors_page_has_a_property_or_a_verb() -> None:
    """Nobody needs the generic way for what the vendor documents."""
    generic = [each.name for each in ROWS if each.source == "page" and ("." in how(each) or "(" in how(each))]
    assert generic == []
