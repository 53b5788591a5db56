"""SECURITY.md names every limit with its default, so that nobody has to read the source for it."""

from __future__ import annotations

import re
from pathlib import Path

from rosproto.bag import BagLimits
from rosproto.msg import DefinitionLimits
from rosproto.protocol.limits import Limits

PAGE = (Path(__file__).resolve().parent.parent / "SECURITY.md").read_text("utf-8")


def rows(title: str) -> dict[str, str]:
    """Name -> default of one table."""
    table = PAGE.partition(f"| `{title}` field |")[2].partition("\n\n")[0]
    return dict(re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", table, re.MULTILINE))


def test_limits() -> None:
    """The table is the class."""
    assert rows("Limits") == {name: str(value) for name, value in Limits._field_defaults.items()}


def test_definition_limits() -> None:
    """The table is the tuple."""
    expected = {name: str(value) for name, value in DefinitionLimits._field_defaults.items()}
    assert rows("DefinitionLimits") == expected


def test_bag_limits() -> None:
    """The table is the tuple."""
    assert rows("BagLimits") == {name: str(value) for name, value in BagLimits._field_defaults.items()}


HELD_BY = {
    "commands no terminal and forges no line": "scenarios/hostile/test_hostile_texts.py",
    "Every operation is bounded before it begins": "unit/cli/test_expression.py",
    "`BagLimits` field": "unit/bag/test_bag_limits.py",
    "is decoded within about 150 times": "unit/codec/test_amplification.py",
}
"""What the page says, and the tests that hold it."""


def test_what_is_said_is_held() -> None:
    """Each of these sentences stands on the page, and its tests are there."""
    for sentence, path in HELD_BY.items():
        assert sentence in PAGE, sentence
        assert "def test_" in (Path(__file__).resolve().parent / path).read_text("utf-8")


def test_every_limit_is_set_by_a_test() -> None:
    """A limit that nobody ever reached may not hold: some unit test or scenario makes each small and runs into it."""
    here = Path(__file__).resolve().parent
    tests = [
        path.read_text("utf-8") for room in ("unit", "scenarios") for path in (here / room).rglob("*.py")
    ]
    for kind in (Limits, DefinitionLimits, BagLimits):
        setting = [text for text in tests if kind.__name__ in text]
        names = kind._field_defaults
        untested = [name for name in names if not any(re.search(rf"\b{name}\b", text) for text in setting)]
        assert not untested, untested
