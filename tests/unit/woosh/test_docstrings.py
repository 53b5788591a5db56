"""What an editor shows beside a name is enough: nobody has to look elsewhere for it."""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path

import pytest

from woosh_pure import readings
from woosh_pure.aio import feed

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("face", [readings.Readings, feed.Readings], ids=["Chassis", "aio.Chassis"])
def test_a_feed_says_what_it_tells(face: type) -> None:
    """More than the name of its topic."""
    feeds = {
        name: inspect.getdoc(value) or "" for name, value in vars(face).items() if isinstance(value, property)
    }
    assert len(feeds) > 15
    assert [name for name, doc in feeds.items() if len(re.sub("`[^`]*`", "", doc)) < 15] == []


@pytest.mark.structure
def test_errors_are_explained_where_they_are_named() -> None:
    """`Raises: ValueError: As in another function` sends the reader away."""
    found = []
    elsewhere = re.compile(r"^ +[\w, ]+: As (in |for )?`", re.MULTILINE)
    for path in [*(ROOT / "rosproto").rglob("*.py"), *(ROOT / "woosh_pure").rglob("*.py")]:
        text = path.read_text("utf-8")
        if not elsewhere.search(text):
            continue  # parsing all of them takes several seconds
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                raises = (ast.get_docstring(node) or "").partition("Raises:\n")[2].partition("\n\n")[0]
                if elsewhere.search(raises):
                    found.append(f"{path.relative_to(ROOT)}: {node.name}")
    assert found == []
