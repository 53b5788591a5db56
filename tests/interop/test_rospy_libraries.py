"""What programs import beside rospy: libraries that Debian may lack, so their outputs are kept.

Each program in `programs/` was run by the real libraries; what it printed lies in `programs/expected/`. Here
our layer runs it, and, where Debian's package is installed, so do rospy and that package once more.
"""

from __future__ import annotations

import random
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.support import ros
from tests.support.rospy_pair import PROGRAMS, run_program

NEEDS = {
    "cameras.py": "image_geometry",
    "diagnostics.py": "diagnostic_updater",
    "kdl.py": "PyKDL",
    "tf_rare.py": "tf.transformations",
}


def expected(program: str) -> list[str]:
    """What the real one printed, on both streams."""
    return (PROGRAMS / "expected" / program).with_suffix(".txt").read_text("utf-8").splitlines()


@pytest.mark.parametrize("program", NEEDS)
def test_a_library_does_what_the_real_one_did(program: str) -> None:
    """Both streams, stdout first; exit code 0."""
    ours = run_program(program, real=False)
    assert [*ours.out, *ours.err] == expected(program)
    assert ours.code == 0


@pytest.mark.parametrize("program", NEEDS)
def test_what_is_kept_is_what_the_real_one_does(program: str, request: pytest.FixtureRequest) -> None:
    """Where Debian's package is there."""
    module = NEEDS[program]
    done = subprocess.run([ros.PYTHON, "-c", f"import {module}"], capture_output=True, timeout=60)
    if done.returncode:
        pytest.skip(f"Debian's Python has no {module}")
    folders: list[Path | str] = ["/usr/lib/python3/dist-packages", request.getfixturevalue("genpy_packages")]
    theirs = run_program(program, real=True, packages=folders)
    assert [*theirs.out, *theirs.err] == expected(program)


@pytest.mark.parametrize(
    ("program", "library"), [("filters.py", "message_filters"), ("action_callbacks.py", "actionlib")]
)
def test_libraries_written_over_rospy_run_over_ours(
    program: str, library: str, genpy_packages: Path, tmp_path: Path
) -> None:
    """Debian's own message_filters and actionlib, under another name because ours stands before them."""
    source = Path("/usr/lib/python3/dist-packages", library)
    ros.require(source.is_dir(), f"there is no {source}")
    name = re.compile(rf"^( *)(import|from) {library}\b(?!\.msg)", re.MULTILINE)
    for file in source.glob("*.py"):
        copy = tmp_path / "theirs" / f"their_{library}" / file.name
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(name.sub(rf"\1\2 their_{library}", file.read_text("utf-8")), "utf-8")
    changed = tmp_path / program
    text = (PROGRAMS / program).read_text("utf-8")
    text = text.replace(f"import {library}\n", f"import their_{library} as {library}\n")
    changed.write_text(name.sub(rf"\1\2 their_{library}", text), "utf-8")
    assert f"their_{library}" in changed.read_text("utf-8")
    with ThreadPoolExecutor(2) as pool:
        theirs = pool.submit(run_program, program, real=True, packages=[genpy_packages])
        ours = pool.submit(run_program, changed, real=False, packages=[tmp_path / "theirs"])
    assert ours.result().compared() == theirs.result().compared()


@pytest.mark.parametrize(
    ("program", "library", "word"),
    [
        ("filters_random.py", "message_filters", "together"),
        ("clouds_random.py", "sensor_msgs.point_cloud2", "Point("),
    ],
)
def test_a_library_does_the_same_with_random_input(program: str, library: str, word: str) -> None:
    """message_filters with clocks that jump, clouds of odd layouts: results, errors and warnings."""
    ros.require_ros(library)
    seed = str(random.randrange(10**9))
    with ThreadPoolExecutor(2) as pool:
        theirs = pool.submit(run_program, program, seed, "150", real=True)
        ours = pool.submit(run_program, program, seed, "150", real=False)
    assert ours.result().compared() == theirs.result().compared(), f"{program} {seed} 150"
    assert sum(word in line for line in ours.result().out) > 9
