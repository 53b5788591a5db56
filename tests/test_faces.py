"""`woosh_pure` stands on what `rosproto` offers: names in the `__all__` of it, or of what is one level below.

`rosproto.node` is a face, `rosproto.node.services.client` is not. What a user of this project may do with
`rosproto`, `woosh_pure` does; what it needs beyond that is made public first. Imports for types count, too.
"""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.test_exports import PACKAGES
from tests.test_layers import MODULES, ROOT

pytestmark = pytest.mark.structure

WOOSH = [(module, path) for module, path in MODULES if module.startswith("woosh_pure")]
COMMANDS = "woosh_pure.cli"
"""The one part of woosh_pure that stands on `rosproto.cli`."""


def imports_from_rosproto(path: Path) -> Iterator[tuple[int, str, str]]:
    """Line, module and name of each import; the name is "" where the module itself is imported."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            pairs = [(node.module, alias.name) for alias in node.names]
        elif isinstance(node, ast.Import):
            pairs = [(alias.name, "") for alias in node.names]
        else:
            continue
        for module, name in pairs:
            if module.partition(".")[0] == "rosproto":
                yield node.lineno, module, name


def is_a_module(name: str) -> bool:
    path = ROOT / name.replace(".", "/")
    return path.is_dir() or path.with_suffix(".py").exists()


def objection(importer: str, module: str, name: str) -> str | None:
    """What is wrong with an import, None when nothing is."""
    if module == "rosproto" and name and is_a_module(f"rosproto.{name}"):
        module, name = f"rosproto.{name}", ""  # from rosproto import tf
    if module.count(".") > 1:
        return f"{module} is inside of a package: import the name from {'.'.join(module.split('.')[:2])}"
    if module.rpartition(".")[2].startswith("_"):
        return f"{module} is private"
    if module == "rosproto.cli" and not f"{importer}.".startswith(f"{COMMANDS}."):
        return f"{module} is for {COMMANDS} only"
    offered = getattr(importlib.import_module(module), "__all__", None)
    if offered is None:
        return f"{module} has no __all__"
    return None if not name or name in offered else f"{module} does not offer {name}"


def test_the_chassis_uses_public_faces_only() -> None:
    """The chassis API could be written by anybody who has `rosproto` and its documentation."""
    assert len(WOOSH) > 100
    found = [
        (path, line, objection(module, *what))
        for module, path in WOOSH
        for line, *what in imports_from_rosproto(path)
    ]
    assert [f"{path.relative_to(ROOT)}:{line} {text}" for path, line, text in found if text] == []


@pytest.mark.parametrize(
    "line",
    [
        "from rosproto.node.services.link import Cancellation",
        "from rosproto.node.services import client",
        "from rosproto.node import services",
        "import rosproto.node.node",
        "from rosproto.cli import counted",
        "from rosproto import cli",
        "from rosproto.coercion import math",
        "from rosproto import __main__",
        "if TYPE_CHECKING:\n    from rosproto.codec.conversion import Conversion",
    ],
)
def test_the_watch_itself_sees_a_wrong_import(tmp_path: Path, line: str) -> None:
    """A check that cannot fail checks nothing."""
    bad = tmp_path / "bad.py"
    bad.write_text(line)
    ((_, module, name),) = imports_from_rosproto(bad)
    assert objection("woosh_pure.feed.feed", module, name)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_name_of_a_package_is_hidden_by_a_module_of_it(package: str) -> None:
    """The first import of `a.b.count` puts the module at `a.b`, in place of a name `count` that is late."""
    module = importlib.import_module(package)
    late = {name for name in module.__all__ if name not in vars(module)}
    assert not {name for name in late if is_a_module(f"{package}.{name}")}
