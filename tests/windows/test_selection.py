"""The tests that a process under Wine selects, and the rest for the next one after an abort."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PURE = """
import pytest

@pytest.mark.parametrize("n", range(9))
def test_of_nine_cases(n): pass

@pytest.mark.parametrize("n", range(9))
def test_with_a_file(n, tmp_path): pass
"""
CUT_OFF = """
import os

def test_a(): pass
def test_b(): assert os.environ["LIFE"] == "second"
def test_c(): assert os.environ["LIFE"] == "second" or os._exit(9)
def test_d(): pass
"""


def run(folder: Path, *options: str, life: str = "first") -> tuple[int, set[str]]:
    """The exit code, and which tests passed."""
    plain = (
        "-p",
        "no:randomly",
        "-p",
        "no:cacheprovider",
        "--import-mode=importlib",
        "-v",
        f"--rootdir={folder}",
    )
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "tests.windows.selection",
            *plain,
            *options,
            str(folder / "tests"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "LIFE": life},
        check=False,
    )
    lines = (line.split() for line in done.stdout.splitlines() if " PASSED" in line)
    return done.returncode, {words[0].partition("::")[2] for words in lines}


@pytest.mark.whole
def test_pure_logic_is_represented_and_what_touches_the_system_is_not_cut(tmp_path: Path) -> None:
    """Three of nine cases; all of a test that asks for a folder."""
    (tmp_path / "tests/unit/msg").mkdir(parents=True)
    (tmp_path / "tests/unit/msg/test_pure.py").write_text(PURE)
    code, passed = run(tmp_path, "--few")
    assert code == 0
    assert {name for name in passed if "nine" in name} == {f"test_of_nine_cases[{n}]" for n in (0, 4, 8)}
    assert len(passed) == 3 + 9


@pytest.mark.whole
def test_the_next_process_takes_what_has_not_passed(tmp_path: Path) -> None:
    """Also tests that had failed before the end without a report."""
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/test_cut_off.py").write_text(CUT_OFF)
    noted = f"--passed={tmp_path / 'passed'}"
    assert run(tmp_path, noted) == (9, {"test_a"})
    assert run(tmp_path, noted, life="second") == (0, {"test_b", "test_c", "test_d"})
    assert run(tmp_path, noted)[0] == 5, "nothing is left"
