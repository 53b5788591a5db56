"""What the documentation says is run: every Python snippet, and the commands README and CI share."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("README*.md"), *(ROOT / "docs").rglob("*.md")])
FENCE = re.compile(r"^```python(?P<flags>[^\n]*)\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)


def snippets() -> list[tuple[str, str]]:
    """(place, code) of every fenced Python block; one marked `no-run` says in its page why it cannot run."""
    found = []
    for page in PAGES:
        text = page.read_text("utf-8")
        for match in FENCE.finditer(text):
            if "no-run" not in match["flags"]:
                line = text.count("\n", 0, match.start()) + 1
                found.append((f"{page.relative_to(ROOT).as_posix()}:{line}", match["code"]))
    return found


SNIPPETS = snippets()


@pytest.mark.slow
@pytest.mark.parametrize(("place", "code"), SNIPPETS, ids=[place for place, _ in SNIPPETS])
def test_a_snippet_runs(place: str, code: str, tmp_path: Path) -> None:
    """A reader who pastes it into a file gets what the page promises: no error."""
    script = tmp_path / "snippet.py"
    script.write_text(code, "utf-8")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, f"{place}\n{done.stdout}\n{done.stderr}"


def test_the_readme_has_its_two_commands_and_ci_calls_the_second() -> None:
    """One line sets up and shows it, one line sets up and tests it; CI runs the same words."""
    readme = (ROOT / "README.md").read_text("utf-8")
    assert "pip install . && woosh demo" in readme
    tests = 'pip install -e ".[test]" && pytest'
    assert tests in readme
    assert tests in (ROOT / ".ci/run").read_text("utf-8")
