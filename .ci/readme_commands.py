"""Run README's two commands word by word, each in a new environment of this Python.

    python .ci/readme_commands.py

The shell is that of this system. `.ci/run` does the same on Debian, with limits, and repetitions for its
network; this needs nothing but Python.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SECONDS = 3600  # for one command; the slowest hosted machine needs a third of it


def commands(readme: str) -> list[str]:
    """The indented lines of README.md that begin with pip."""
    found = re.findall(r"^    (pip install .*)$", readme, re.MULTILINE)
    if len(found) != 2:
        raise SystemExit(f"README.md has not two commands that begin with pip, but {found}")
    return found


def main() -> int:
    for command in commands((ROOT / "README.md").read_text("utf-8")):
        with tempfile.TemporaryDirectory(prefix="readme-", ignore_cleanup_errors=True) as name:
            # Links, as from `python -m venv`: a copied interpreter may not find the libraries beside it.
            venv.create(name, with_pip=True, symlinks=sys.platform != "win32")
            programs = Path(name) / ("Scripts" if sys.platform == "win32" else "bin")
            environment = os.environ | {
                "VIRTUAL_ENV": name,
                "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
                "PYTHONUTF8": "1",  # of the log alone: its reader expects UTF-8 on Windows, too
            }
            print(f"\n== {command}", flush=True)
            done = subprocess.run(
                command, shell=True, cwd=ROOT, env=environment, check=False, timeout=SECONDS
            )
            if done.returncode:
                print(f"== failed with {done.returncode}: {command}", flush=True)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
