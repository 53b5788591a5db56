"""The API reference has every public name: nobody has to read the source to learn that something exists."""

from __future__ import annotations

import importlib
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = [
    "rosproto", "rosproto.action", "rosproto.aio", "rosproto.bag", "rosproto.gateway",
    "rosproto.gateway.foxglove", "rosproto.gateway.rosbridge.rosapi", "rosproto.node", "rosproto.numeric",
    "rosproto.recording", "rosproto.tf", "woosh_pure", "woosh_pure.aio", "woosh_pure.fleet", "woosh_pure.sim",
    "woosh_pure.web",
]  # fmt: skip


# What Recorder and Player are made of; rosproto.master likewise, of which Master is a name of rosproto's.
BUILDING_BLOCKS = {"BagSeries", "MessageBuffer", "Pacer", "bag_name"}


@cache
def directives() -> set[str]:
    """What mkdocstrings is told to show: modules, and single classes."""
    pages = (ROOT / "docs/api").glob("*.md")
    return {
        name for page in pages for name in re.findall(r"^::: (\S+)$", page.read_text("utf-8"), re.MULTILINE)
    }


@pytest.mark.parametrize(
    ("package", "name"),
    [
        (package, name)
        for package in PACKAGES
        for name in importlib.import_module(package).__all__
        if name not in BUILDING_BLOCKS
    ],
)
def test_a_public_name_is_in_the_reference(package: str, name: str) -> None:
    """By itself, or with the module that defines it."""
    found = getattr(importlib.import_module(package), name)
    if type(found).__name__ == "module":
        return  # its names are asked for one by one
    home = getattr(found, "__module__", package)
    assert {home, f"{home}.{name}"} & directives(), f"{package}.{name} of {home}"


@pytest.mark.parametrize("directive", sorted(directives()))
def test_what_the_reference_shows_is_there(directive: str) -> None:
    """A directive that has lost its object would be noticed by mkdocs only, which few have."""
    module, _, name = directive.rpartition(".")
    try:
        importlib.import_module(directive)
    except ModuleNotFoundError:
        assert hasattr(importlib.import_module(module), name)


def test_every_page_is_in_the_menu() -> None:
    """Each page of docs/ stands in mkdocs.yml, and so can be found."""
    menu = (ROOT / "mkdocs.yml").read_text("utf-8")
    for page in (ROOT / "docs").rglob("*.md"):
        assert f"{page.relative_to(ROOT / 'docs').as_posix()}\n" in menu, page.name
