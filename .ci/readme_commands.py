"""Run README's two commands word by word, each in a new environment of this Python.

    python .ci/readme_commands.py
    python .ci/readme_commands.py WORD FOLDER     only the one with WORD, in an environment kept in FOLDER

The shell is that of this system, and nothing but Python is needed.
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


def run(command: str, folder: str) -> int:
    """Run a command in a new environment; its exit code."""
    # Links, as from `python -m venv`: a copied interpreter may not find the libraries beside it.
    venv.create(folder, clear=True, with_pip=True, symlinks=sys.platform != "win32")
    programs = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin")
    environment = os.environ | {
        "VIRTUAL_ENV": folder,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
    }
    if sys.platform == "win32":
        environment["PYTHONUTF8"] = "1"  # who reads the log expects UTF-8
    print(f"\n== {command}", flush=True)
    return subprocess.run(
        command, shell=True, cwd=ROOT, env=environment, check=False, timeout=SECONDS
    ).returncode


def main() -> int:
    wanted = commands((ROOT / "README.md").read_text("utf-8"))
    if len(sys.argv) == 3:
        (wanted,) = (command for command in wanted if sys.argv[1] in command.split())
        return run(wanted, sys.argv[2])
    for command in wanted:
        with tempfile.TemporaryDirectory(prefix="readme-", ignore_cleanup_errors=True) as folder:
            if code := run(command, folder):
                print(f"== failed with {code}: {command}", flush=True)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
