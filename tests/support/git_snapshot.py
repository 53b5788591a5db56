"""One commit of a public repository, taken from GitHub for tests that compare with it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

__all__ = ["take"]


def take(what: str, repository: str, commit: str, folder: Path, *paths: str) -> None:
    """Check out a commit, or these paths of it, into a folder that does not exist yet.

    Raises:
        RuntimeError: A step failed; includes the message of git.
    """
    for words in (
        ["init", "--quiet", str(folder)],
        ["-C", str(folder), "fetch", "--quiet", "--depth", "1", repository, commit],
        ["-C", str(folder), "checkout", "--quiet", "FETCH_HEAD", *(["--", *paths] if paths else [])],
    ):
        done = subprocess.run(
            ["git", *words],
            capture_output=True,
            text=True,
            timeout=100,
            env={**os.environ, "GIT_TERMINAL_PROMPT": "0"},
        )
        if done.returncode:
            raise RuntimeError(f"{what} cannot be had: {done.stderr.strip()[-300:]}")
