"""Which tests the quick check runs for which change."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools import quick
from tools.quick import ROOT

EXISTS = frozenset(
    "tests tests/unit tests/unit/msg tests/unit/node tests/unit/node/incoming tests/unit/woosh tests/unit/woosh_cli "
    "tests/unit/tools tests/unit/msg/test_md5.py".split()
)


@pytest.mark.parametrize(
    ("path", "tests"),
    [
        ("rosproto/msg/spec.py", ["tests/unit/msg"]),
        ("rosproto/node/incoming/reader.py", ["tests/unit/node/incoming"]),
        ("rosproto/node/outgoing/queued_link.py", ["tests/unit/node"]),
        ("rosproto/names.py", ["tests/unit"]),
        ("woosh_pure/stopping/stop.py", ["tests/unit/woosh"]),
        ("woosh_pure/cli/commands/driving.py", ["tests/unit/woosh_cli"]),
        ("tools/stubs.py", ["tests/unit/tools"]),
        ("msgdefs/std_msgs/msg/Header.msg", ["tests/unit/msg"]),
        ("tests/unit/msg/test_md5.py", ["tests/unit/msg/test_md5.py"]),
        ("tests/unit/msg/gone.py", ["tests/unit/msg"]),
        ("README.md", []),
        ("tests/scenarios/test_stop.py", []),
    ],
)
def test_a_change_has_its_tests(path: str, tests: list[str]) -> None:
    assert quick.tests_of([path], EXISTS) == tests


def test_a_folder_includes_its_files() -> None:
    """Nothing is run twice."""
    assert quick.tests_of(["tests/unit/msg/test_md5.py", "rosproto/msg/spec.py"], EXISTS) == [
        "tests/unit/msg"
    ]


def test_every_source_folder_has_tests_of_its_own_or_above() -> None:
    """As the house stands now, no folder is left without any."""
    exists = frozenset(p.relative_to(ROOT).as_posix() for p in (ROOT / "tests").rglob("*"))
    for package in ("rosproto", "woosh_pure"):
        for path in (ROOT / package).rglob("*.py"):
            (found,) = quick.tests_of([path.relative_to(ROOT).as_posix()], exists)
            assert Path(ROOT, found).is_dir()
