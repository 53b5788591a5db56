"""Every package has an `__all__`; each name in it exists, and each name that other files import is in it."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import resolve_name
from pathlib import Path

import pytest

from tests.test_layers import MODULES, parsed

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = sorted(
    ".".join(path.parent.relative_to(ROOT).parts)
    for top in ("rosproto", "woosh_pure")
    for path in (ROOT / top).rglob("__init__.py")
    # Stand-ins for ROS's own packages: importable under those names only, inside `rosproto run`.
    if "rosproto/rospy/modules" not in path.as_posix()
)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_of_all_can_be_imported(package: str) -> None:
    """`__all__` exists, and holds no name twice and none that the package lacks."""
    module = importlib.import_module(package)
    names = list(module.__all__)
    assert len(names) == len(set(names)), f"{package}.__all__ names something twice"
    missing = [name for name in names if not hasattr(module, name)]
    assert not missing, f"{package}.__all__ names what is not there: {missing}"


@pytest.mark.parametrize("package", PACKAGES)
def test_no_star_imports(package: str) -> None:
    """Names come in one by one, so that a reader sees where each is from."""
    tree = ast.parse((ROOT / package.replace(".", "/") / "__init__.py").read_text("utf-8"))
    stars = [n.lineno for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.names[0].name == "*"]
    assert not stars


@cache
def declared(path: Path) -> frozenset[str] | None:
    """The names of the `__all__` of a file; None when it has none, or computes it."""
    for node in parsed(path).body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and isinstance(node.value, ast.List):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            if ast.unparse(target) == "__all__":
                return frozenset(str(ast.literal_eval(name)) for name in node.value.elts)
    return None


def undeclared_imports(files: Iterable[tuple[str, Path]], modules: dict[str, Path]) -> Iterator[str]:
    """Each `from module import name` of a module whose `__all__` lacks the name."""
    for importer, path in files:
        package = importer if path.name == "__init__.py" else importer.rpartition(".")[0]
        for node in ast.walk(parsed(path)):
            if not isinstance(node, ast.ImportFrom):
                continue
            module = resolve_name("." * node.level + (node.module or ""), package)
            names = declared(modules[module]) if module in modules else None
            for alias in node.names:
                inside = alias.name == "*" or f"{module}.{alias.name}" in modules
                if names is not None and alias.name not in names and not inside:
                    yield f"{path}:{node.lineno} imports {alias.name}, which {module}.__all__ lacks"


@pytest.mark.slow  # reads all sources
def test_a_name_that_another_file_imports_is_in_all() -> None:
    """Where a file has an `__all__`, it lists every name that other files import from it.

    The stand-ins for ROS's own packages have ROS's lists.
    """
    modules = {module: path for module, path in MODULES if "rosproto.rospy.modules" not in module}
    assert list(undeclared_imports(modules.items(), modules)) == []


def test_the_check_finds_a_name_that_all_lacks(tmp_path: Path) -> None:
    """A check that cannot fail checks nothing."""
    offers, takes = tmp_path / "offers.py", tmp_path / "takes.py"
    offers.write_text("__all__ = ['known']\nknown = secret = 1\n")
    takes.write_text("from .offers import known, secret\n")
    files = {"p.offers": offers, "p.takes": takes}
    (found,) = undeclared_imports(files.items(), files)
    assert "imports secret" in found
