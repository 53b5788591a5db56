"""Every example runs to a good end: those that take a robot's address on one simulated chassis, the others alone."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.extras import needs
from tests.support.robot_pool import RobotPool
from tests.support.warm import WarmPython

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted(p.name for p in (ROOT / "examples").glob("*.py") if not p.name.startswith("_"))
pytestmark = [pytest.mark.slow, pytest.mark.example]  # some drive for seconds


@pytest.fixture(scope="module")
def python() -> Iterator[WarmPython]:
    with WarmPython() as warm:
        yield warm


@pytest.fixture(scope="module")
def robots() -> Iterator[RobotPool]:
    with RobotPool() as pool:
        yield pool


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_runs(name: str, python: WarmPython, robots: RobotPool, tmp_path: Path) -> None:
    """`examples/_robot.py` takes the address of the command line, or starts a chassis of its own (see below)."""
    script = ROOT / "examples" / name
    if re.search(r"^(?:from|import) mcp\b", script.read_text("utf-8"), re.MULTILINE):
        needs("mcp")
    if uses := re.search(r"\brobot\((?:speed=([\d.]+))?\)", script.read_text("utf-8")):
        robot = robots.take(float(uses[1] or 8.0))
        done = python.run(script, tmp_path, [robot.sim.master_uri])
        robots.give_back(robot)
    else:
        done = python.run(script, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout.strip()


def test_an_example_runs_without_arguments(tmp_path: Path) -> None:
    """As typed: `python examples/read_state.py`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    environment.pop("ROS_MASTER_URI", None)
    result = subprocess.run(
        [sys.executable, str(ROOT / "examples" / "read_state.py")],
        capture_output=True, text=True, encoding="utf-8", timeout=90, env=environment, cwd=tmp_path,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "battery 87 %" in result.stdout
