"""The page's modules by themselves: unit tests run by Node, and eslint where it is installed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.ros_process import require

ROOT = Path(__file__).parents[2]
MODULES = ROOT / "woosh_pure" / "web" / "page" / "js"


def run(*command: str | Path) -> None:
    """A program that must end well, within a minute."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]


@pytest.mark.slow
def test_the_modules_do_what_their_tests_say() -> None:
    """`node --test`, from Node 20 on."""
    node = shutil.which("node")
    require(node is not None, "node is not installed")
    assert node is not None
    version = subprocess.run(
        [node, "--version"], capture_output=True, text=True, timeout=20, check=True
    ).stdout
    require(int(version[1:].split(".")[0]) >= 20, f"node {version.strip()}: from 20 on")
    run(node, "--test", *sorted((ROOT / "tests" / "web" / "page").glob("*.test.mjs")))


@pytest.mark.slow
def test_the_linter_has_nothing_to_say() -> None:
    """eslint, looked for in $WOOSH_ESLINT (the folder with its node_modules), else in PATH."""
    folder = os.environ.get("WOOSH_ESLINT")
    found = shutil.which("eslint", path=f"{folder}/node_modules/.bin" if folder else None)
    require(
        found is not None,
        "eslint is not installed (npm install --prefix FOLDER eslint@9; WOOSH_ESLINT=FOLDER)",
    )
    assert found is not None
    run(
        found,
        "--config",
        "tests/web/eslint.config.mjs",
        "--max-warnings",
        "0",
        MODULES,
        "tests/web/page",
        "examples/web",
    )


def test_no_file_of_the_page_is_long() -> None:
    """One thing each, at most 300 lines."""
    files = [path for path in MODULES.parent.rglob("*") if path.suffix in (".js", ".css", ".html")]
    assert len(files) > 30
    for path in files:
        assert len(path.read_text("utf-8").splitlines()) <= 300, path.name
