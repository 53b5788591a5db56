"""`bash .ci/run quick`: style, types, pages, layers, the unit tests of what changed, in less than a minute.

Needs `pip install -e ".[dev]"` and nothing else: no ROS, no Wine, no network. What changed is what differs
from the commit in `$QUICK_BASE` (default: HEAD), with files that git does not track yet; where nothing does,
all unit tests run.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from tools.layers import TESTS_OF

ROOT = Path(__file__).resolve().parent.parent
ALWAYS = ("tests/test_layers.py", "tests/test_faces.py", "tests/test_exports.py")


def changed(base: str) -> list[str]:
    """Paths that differ from a commit, or are new."""
    listings = (["git", "diff", "--name-only", base], ["git", "ls-files", "--others", "--exclude-standard"])
    return sorted(
        {
            path
            for command in listings
            for path in subprocess.run(
                command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=30
            ).stdout.splitlines()
        }
    )


def tests_of(paths: Iterable[str], exists: frozenset[str]) -> list[str]:
    """The test files and folders of changed files; all unit tests when a changed file has none of its own.

    Args:
        paths: Files that changed, relative to the root.
        exists: Files and folders below tests/ that there are.
    """
    found: set[str] = set()
    for path in paths:
        folder, _, name = path.rpartition("/")
        if path.startswith("tests/unit/") and name.startswith("test_"):
            found.add(path)
        elif path.startswith("tests/unit/"):
            found.add(folder)
        elif path.endswith(".py") and path.startswith(("rosproto/", "woosh_pure/", "tools/")):
            found.add(_folder_of(folder, exists))
        elif path.startswith("msgdefs/"):
            found.add("tests/unit/msg")
    kept = {path for path in found if path in exists}
    return sorted(path for path in kept if not any(path.startswith(f"{other}/") for other in kept))


def _folder_of(source: str, exists: frozenset[str]) -> str:
    """The folder of tests that is the nearest to a source folder."""
    while source:
        for start, tests in TESTS_OF.items():
            if source == start or source.startswith(f"{start}/"):
                candidate = tests + source.removeprefix(start)
                if candidate in exists:
                    return candidate
        candidate = source.replace("rosproto", "tests/unit", 1)
        if candidate in exists:
            return candidate
        source = source.rpartition("/")[0]
    return "tests/unit"


def main() -> int:
    """Run them side by side; 0 when all passed."""
    began = time.monotonic()
    exists = frozenset(path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("*"))
    tests = tests_of(changed(os.environ.get("QUICK_BASE", "HEAD")), exists) or ["tests/unit"]
    # Coverage, the slow and the ones that need a peer are for the whole check.
    pytest = ["-m", "pytest", "-q", "-n", "4", "-m", "not (slow or whole or interop)", *ALWAYS, *tests]
    steps = {
        "style": ["-m", "ruff", "check", "."],
        "format": ["-m", "ruff", "format", "--check", "--quiet", "."],
        "types": ["-m", "mypy"],
        "pages": ["-m", "tools.page_lint"],
        "tests": pytest,
    }
    print("tests:", *tests, flush=True)
    running = {
        name: subprocess.Popen(
            [sys.executable, *words], cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        for name, words in steps.items()
    }
    failed = []
    for name, process in running.items():
        output = process.communicate(timeout=600)[0]
        if process.returncode:
            failed.append(name)
            print(f"== {name}\n{output.rstrip()}", flush=True)
        else:
            print(f"{name}: {(output.rstrip().splitlines() or ['ok'])[-1]}", flush=True)
    print(f"{'FAILED: ' + ', '.join(failed) if failed else 'All is well.'} {time.monotonic() - began:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
