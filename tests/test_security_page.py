"""SECURITY.md names every limit with its default, so that nobody has to read the source for it."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from rosproto.bag import BagLimits
from rosproto.gateway import GatewayLimits
from rosproto.msg import DefinitionLimits
from rosproto.protocol.wire_limits import Limits

PAGE = (Path(__file__).resolve().parent.parent / "SECURITY.md").read_text("utf-8")

RUNS_CODE = {
    "rosproto/cli/expression.py": "a filter that the user types, its syntax tree checked before",
    "rosproto/codec/conversion.py": "values carried over between two revisions, from names of fields",
    "rosproto/codec/generated_source.py": "encoders and decoders, from definitions",
    "rosproto/rospy/launch.py": "a program of the user's: `rosproto run`",
    "woosh_pure/cli/commands/start.py": "what the user types: `woosh shell`",
}
"""Where Python code is made and run, and of what."""


@pytest.mark.structure
@pytest.mark.promise("Nothing that is received is evaluated")
def test_code_is_made_and_run_in_these_places_only() -> None:
    """No eval, no exec of remote text, no pickle: a new place has to be looked at, and named here."""
    root = Path(__file__).resolve().parent.parent
    found = set()
    for path in (*(root / "rosproto").rglob("*.py"), *(root / "woosh_pure").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            called = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id
            loads = {"pickle", "marshal", "shelve"} & {
                name.name.partition(".")[0] for name in (node.names if isinstance(node, ast.Import) else ())
            } or (isinstance(node, ast.ImportFrom) and node.module in ("pickle", "marshal", "shelve"))
            if called in ("eval", "exec") or loads:
                found.add(path.relative_to(root).as_posix())
    assert found == set(RUNS_CODE)


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


def test_gateway_limits() -> None:
    """The table is the tuple."""
    assert rows("GatewayLimits") == {name: str(v) for name, v in GatewayLimits._field_defaults.items()}


def test_bag_limits() -> None:
    """The table is the tuple."""
    assert rows("BagLimits") == {name: str(value) for name, value in BagLimits._field_defaults.items()}


@pytest.mark.promise("Every length from the wire is compared with these")
def test_every_limit_is_set_by_a_test() -> None:
    """A limit that nobody ever reached may not hold: some unit test or scenario makes each small and runs into it."""
    here = Path(__file__).resolve().parent
    tests = [
        path.read_text("utf-8") for room in ("unit", "scenarios") for path in (here / room).rglob("*.py")
    ]
    for kind in (Limits, DefinitionLimits, BagLimits, GatewayLimits):
        setting = [text for text in tests if kind.__name__ in text]
        names = kind._field_defaults
        untested = [name for name in names if not any(re.search(rf"\b{name}\b", text) for text in setting)]
        assert not untested, untested
