"""The stand-ins for ROS's modules: files that Python finds, compiles and caches as it does all others, also in a zip."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from rosproto.rospy.finder import MODULES, FallbackFinder, RosFinder

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])  # CPython for embedding takes no PYTHONPATH
from rosproto.rospy import finder
finder.serve()
import rospy, rospy.impl.init, actionlib.action_client, rosbag, tf.transformations as tf
from sensor_msgs import point_cloud2
from rospy.msg import AnyMsg
import inspect
assert inspect.getsource(rospy.Rate).startswith("class Rate")
print(type(rospy.__loader__).__name__, rospy.__file__.startswith(sys.argv[1]))
try:
    import rospy.nothing
except ImportError as error:
    print(error)
tf.euler_from_quaternion("no quaternion at all")
"""


def run(where: Path) -> subprocess.CompletedProcess[str]:
    """The program, with our packages from that folder or zip."""
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, str(where)],
        capture_output=True, text=True, timeout=60, check=False, env={**os.environ, "PYTHONPATH": str(where)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def zipped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The packages as a zip, which is what a wheel is."""
    file = tmp_path_factory.mktemp("zip") / "packages.zip"
    with zipfile.ZipFile(file, "w") as archive:
        for package in ("rosproto", "msgdefs"):
            for path in sorted((ROOT / package).rglob("*")):
                if path.is_file() and "__pycache__" not in path.parts:
                    archive.write(path, path.relative_to(ROOT).as_posix())
    return file


def test_a_program_runs_from_files() -> None:
    """Modules, packages, modules inside packages, what lies in message packages; errors name their place."""
    check(run(ROOT), "SourceFileLoader True")


def test_a_program_runs_from_a_zip(zipped: Path) -> None:
    """The same where no file is on the disk."""
    check(run(zipped), "zipimporter True")


NO_PART = "this layer has no such part of rospy, whose connections and commands are rosproto's here"


def check(done: subprocess.CompletedProcess[str], loader: str) -> None:
    assert done.returncode == 1
    assert done.stdout == f"{loader}\nNo module named 'rospy.nothing': {NO_PART}\n", done.stderr
    assert "modules/tf/transformations.py" in done.stderr.replace("\\", "/")


def test_every_file_is_found_under_its_name() -> None:
    """And nothing else is: no folder without modules, no name that only begins alike."""
    finder, spare = RosFinder(), FallbackFinder()
    for path in Path(MODULES).rglob("*.py"):
        inner = path.relative_to(MODULES)
        parts = list(inner.parent.parts if path.stem == "__init__" else inner.with_suffix("").parts)
        if parts[0] == "_submodules":
            parts = parts[1:]
            if len(parts) < 2:
                continue  # the message package itself is made from its definitions
        name = ".".join(parts)
        spec = finder.find_spec(name, None) or spare.find_spec(name, None)
        assert spec is not None, name
        assert spec.origin == str(path), name
        assert (spec.submodule_search_locations is not None) is (path.stem == "__init__")
    for absent in ("rospy.nothing", "angles.inside", "rosp", "_submodules"):
        assert finder.find_spec(absent, None) is None, absent
