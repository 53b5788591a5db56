"""Runs a program by `python -m rosproto.rospy` in a separate process."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

__all__ = ["ROOT", "output", "run"]

ROOT = Path(__file__).resolve().parents[2]


def run(
    code: str,
    tmp_path: Path,
    *,
    uri: str = "http://127.0.0.1:1/",
    options: list[str] | None = None,
    **env: str,
):
    """Run a program by `python -m rosproto.rospy`; return its CompletedProcess."""
    program = tmp_path / "program.py"
    program.write_text(textwrap.dedent(code), "utf-8")
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "ROS_MASTER_URI": uri,
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
        **env,
    }
    return subprocess.run(
        [sys.executable, "-m", "rosproto.rospy", *(options or []), str(program), "one", "--two", "_x:=3"],
        capture_output=True,
        text=True,
        timeout=100,
        env=environment,
    )


def output(code: str, tmp_path: Path, **options: object) -> str:
    """The program's stdout; fails unless it exits with 0."""
    done = run(code, tmp_path, **options)  # type: ignore[arg-type]
    assert done.returncode == 0, done.stderr
    return done.stdout
