"""Output of the examples in a Windows pipe, which has the machine's code page."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
@pytest.mark.example
def test_an_example_escapes_what_the_pipe_lacks(tmp_path: Path) -> None:
    """Chinese texts of status codes, in `python examples/faults.py > faults.txt`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "cp1252"}
    environment.pop("ROS_MASTER_URI", None)
    done = subprocess.run(
        [sys.executable, str(ROOT / "examples/faults.py")],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        encoding="cp1252",
        timeout=90,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "/ \\u" in done.stdout
