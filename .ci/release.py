"""Make what a release consists of: the tested wheel, the sdist, and the notes.

    python .ci/release.py v0.9.0 FOLDER

The tag, `rosproto/version.py` and a section of CHANGELOG.md must name the same version. FOLDER/dist gets the
wheel and the sdist that `tests/packaging/check.py` has tested in a bare environment, FOLDER/notes.md the
section.
"""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def notes(changelog: str, version: str) -> str:
    """The section of a version, without its heading."""
    heading = rf"^## {re.escape(version)} \(\d{{4}}-\d\d-\d\d\)$"
    found = re.search(rf"{heading}(.*?)(?=^## |\Z)", changelog, re.MULTILINE | re.DOTALL)
    if found is None or not found[1].strip():
        raise SystemExit(f"CHANGELOG.md has no section '## {version} (year-month-day)', or it is empty")
    return found[1].strip() + "\n"


def check(tag: str, version: str) -> None:
    if tag != f"v{version}":
        raise SystemExit(f"the tag is {tag}, and rosproto/version.py says {version}: expected v{version}")


def main() -> int:
    if len(sys.argv) != 3:
        raise SystemExit("usage: python .ci/release.py TAG FOLDER")
    tag, folder = sys.argv[1], Path(sys.argv[2])
    version = runpy.run_path(str(ROOT / "rosproto/version.py"))["__version__"]
    check(tag, version)
    text = notes((ROOT / "CHANGELOG.md").read_text("utf-8"), version)
    (folder / "dist").mkdir(parents=True)
    (folder / "notes.md").write_text(text, "utf-8")
    words = [sys.executable, ROOT / "tests/packaging/check.py", "--keep", folder / "dist"]
    return subprocess.run(words, check=False, timeout=3600).returncode


if __name__ == "__main__":
    sys.exit(main())
