"""What runs elsewhere is small, pinned and bounded: the workflows, and the scripts in .ci that they call."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest
import yaml

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
RELEASE = runpy.run_path(str(ROOT / ".ci/release.py"), run_name="release")
README = runpy.run_path(str(ROOT / ".ci/readme_commands.py"), run_name="readme")


def jobs() -> list[tuple[str, dict[str, Any]]]:
    """Every job with the name of its workflow."""
    found = []
    for path in WORKFLOWS:
        found += [(path.name, job) for job in yaml.safe_load(path.read_text("utf-8"))["jobs"].values()]
    return found


def test_every_action_is_pinned_by_its_hash() -> None:
    uses = [step["uses"] for _, job in jobs() for step in job["steps"] if "uses" in step]
    assert len(uses) > 10
    assert [name for name in uses if not re.fullmatch(r"[\w/.-]+@[0-9a-f]{40}", name)] == []


def test_a_workflow_may_only_read_and_a_job_says_what_else_and_how_long() -> None:
    for path in WORKFLOWS:
        assert yaml.safe_load(path.read_text("utf-8"))["permissions"] == {"contents": "read"}, path
    for name, job in jobs():
        assert job["timeout-minutes"] <= 300, name
        assert "write" not in job.get("permissions", {}).values() or name in {
            "release.yml",
            "docs.yml",
            "codeql.yml",
        }


def test_the_steps_call_scripts_and_have_no_logic_of_their_own() -> None:
    lines = [step["run"] for _, job in jobs() for step in job["steps"] if "run" in step]
    assert [line for line in lines if "\n" in line.strip() or " if " in line or " for " in line] == []
    for line in lines:
        for script in re.findall(r"\.ci/[\w.]+", line):
            assert (ROOT / script).exists(), script


def test_the_commands_of_readme_are_those_that_ci_runs() -> None:
    assert README["commands"]((ROOT / "README.md").read_text("utf-8")) == [
        "pip install . && woosh demo",
        'pip install -e ".[test]" && pytest',
    ]
    with pytest.raises(SystemExit, match="not two commands"):
        README["commands"]("    pip install .\n")


def test_a_release_has_one_version_everywhere_and_notes() -> None:
    version = runpy.run_path(str(ROOT / "rosproto/version.py"))["__version__"]
    assert RELEASE["notes"]((ROOT / "CHANGELOG.md").read_text("utf-8"), version)
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
    with pytest.raises(SystemExit, match=r"expected v9\.9\.9"):
        RELEASE["check"]("v1.0.0", "9.9.9")
    text = "# Changes\n\n## 2.0.0 (2030-01-02)\n\n- two\n\n## 1.0.0 (2030-01-01)\n\n- one\n"
    assert RELEASE["notes"](text, "2.0.0") == "- two\n"
    assert RELEASE["notes"](text, "1.0.0") == "- one\n"
    with pytest.raises(SystemExit, match=r"no section '## 3\.0\.0"):
        RELEASE["notes"](text, "3.0.0")
