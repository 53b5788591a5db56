"""The vendor's Python SDK for the Robot API, unchanged, as a client of our server.

No registry has it, so `python -m tests.support.woosh_sdk` takes one commit of a public copy from GitHub into the cache,
with the two libraries that it pins in an environment of their own, as .ci/run does. WOOSH_SDK names another folder with
`woosh_robot_py` and `venv`. Nothing of it is part of this project.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ros
from tests.support.git_snapshot import take
from tests.support.web_peers import cache

__all__ = ["folder", "install", "python"]

VARIABLE = "WOOSH_SDK"
REPOSITORY = "https://github.com/kafeiyin00/MapDataManager.git"
COMMIT = "63b199a768e6a4278fa5e2b0acf32e182f318014"
PACKAGES = ("protobuf==4.21.0", "websockets==15.0")


def _place() -> Path:
    named = os.environ.get(VARIABLE)
    return Path(named) if named else cache() / f"woosh-sdk-{COMMIT[:12]}"


def folder() -> Path:
    """The folder `woosh_robot_py`; skips the running test if it is not there."""
    place = _place()
    found = (place / "woosh_robot_py" / "examples" / "monitor.py").is_file() and python().exists()
    if not found and VARIABLE not in os.environ:
        pytest.skip(
            f"the vendor's SDK is not here: `python -m tests.support.woosh_sdk` gets it from GitHub, or {VARIABLE}"
            " names a folder with woosh_robot_py and venv"
        )
    ros.require(found, f"{VARIABLE}={place} has no woosh_robot_py with a venv beside it")
    return place / "woosh_robot_py"


def python() -> Path:
    """Its Python."""
    return _place() / "venv" / "bin" / "python"


def install() -> Path:
    """Take it into the cache, unless it is there; return its folder.

    Raises:
        RuntimeError: A step failed; includes the message of git or pip.
    """
    target = _place()
    target.parent.mkdir(parents=True, exist_ok=True)
    with ros.exclusive(target.with_suffix(".lock")):
        if not (target / "venv" / "done").exists():
            shutil.rmtree(target, ignore_errors=True)
            take("the vendor's SDK", REPOSITORY, COMMIT, target, "woosh_robot_py")
            for command in (
                [sys.executable, "-m", "venv", str(target / "venv")],
                [str(python()), "-m", "pip", "install", "-q", *PACKAGES],
            ):
                done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
                if done.returncode:
                    raise RuntimeError(f"the vendor's SDK cannot be had: {done.stderr.strip()[-300:]}")
            (target / "venv" / "done").touch()
    return target / "woosh_robot_py"


if __name__ == "__main__":
    try:
        print(install())
    except (OSError, RuntimeError, subprocess.TimeoutExpired) as problem:
        sys.exit(str(problem))
