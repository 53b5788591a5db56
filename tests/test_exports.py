"""Every package says what it offers: explicit `__all__`, each name there is real."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

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
