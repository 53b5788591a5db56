"""docs/architecture.md leads somewhere: every path on it exists, and it opens every room."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs/architecture.md").read_text("utf-8")
NAMED = sorted(set(re.findall(r"`([^`\s]+)`", PAGE)))
PATHS = [name for name in NAMED if "/" in name.strip("/") and not name.startswith("/")]


@pytest.mark.parametrize("path", PATHS)
def test_a_path_exists(path: str) -> None:
    """Folders end in a slash, so that a file is not taken for one."""
    found = ROOT / path
    assert found.is_dir() if path.endswith("/") else found.is_file()


def test_files_are_named_with_their_folder() -> None:
    """`goal.py` alone could be any of several, and could not be checked."""
    assert [name for name in NAMED if re.search(r"\.(py|json|md|txt)$", name) and "/" not in name] == []
    assert len(PATHS) > 80


def rooms() -> list[str]:
    """Every package of the three floors a reader walks through."""
    return sorted(
        f"{file.parent.relative_to(ROOT).as_posix()}/"
        for floor in ("rosproto", "rosproto/node", "woosh_pure")
        for file in (ROOT / floor).glob("*/__init__.py")
    )


def test_every_room_is_opened() -> None:
    assert [room for room in rooms() if f"`{room}`" not in PAGE] == []


def test_every_folder_of_tests_is_named() -> None:
    """Somebody who changes a thing must find what would notice."""
    folders = {path.parent for path in (ROOT / "tests").glob("*/*.py")}
    assert [f for f in sorted(folders) if f"`{f.relative_to(ROOT).as_posix()}/`" not in PAGE] == []


def test_each_change_has_its_place_and_its_tests() -> None:
    """No empty cell in the table of changes, and tests in each row."""
    rows = re.findall(r"^\| (.+) \| (.+) \| (.+) \|$", PAGE.partition("| I want to change")[2], re.MULTILINE)
    assert len(rows) > 25
    for change, _, tests in rows:
        assert "`tests/" in tests, change


def test_a_motion_is_understood_in_eleven_files() -> None:
    """From the verb to the bytes and back: one object owns a motion, so nobody walks to and fro."""
    journey = PAGE.partition("## Journey 2")[2].partition("\n## ")[0]
    assert len(set(re.findall(r"`([^`]+\.py)`", journey))) <= 11
