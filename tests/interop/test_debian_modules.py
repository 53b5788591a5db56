"""Every Python module of Debian's ROS 1 packages, imported by `rosproto run` where no ROS is: it is there, or refused in words."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ros

DEBIAN = Path("/usr/lib/python3/dist-packages")
PACKAGES = (
    *("actionlib", "actionlib_msgs", "catkin", "diagnostic_msgs", "diagnostic_updater", "gencpp", "genlisp"),
    *(
        "genmsg",
        "genpy",
        "geometry_msgs",
        "message_filters",
        "move_base_msgs",
        "rosbag",
        "rosclean",
        "roscpp",
    ),
    *("roscreate", "rosgraph", "rosgraph_msgs", "roslaunch", "roslib", "roslz4", "rosmaster", "rosmsg"),
    *("rosnode", "rosparam", "rospkg", "rospy", "rosservice", "rostest", "rostopic", "rosunit", "roswtf"),
    *("sensor_msgs", "std_msgs", "tf", "tf2_msgs", "tf2_py", "tf2_ros"),
)
"""What `.ci/run` installs. Tools that use no ROS (catkin_pkg, rosdistro, wstool ...) are not among them."""
ROOT = Path(__file__).resolve().parents[2]

PROGRAM = """
import importlib, json, sys

told = {}
for name in json.load(sys.stdin):
    try:
        importlib.import_module(name)
        told[name] = ""
    except BaseException as error:
        told[name] = f"{type(error).__name__}: {error}"
print(json.dumps(told))
"""


def modules() -> list[str]:
    """The names of all modules of these packages, those of single messages too."""
    files = [file for name in PACKAGES for file in (DEBIAN / name).rglob("*.py")]
    files += [DEBIAN / f"{name}.py" for name in PACKAGES if (DEBIAN / f"{name}.py").is_file()]
    parts = (file.relative_to(DEBIAN).with_suffix("").parts for file in files)
    return sorted({".".join(part).removesuffix(".__init__") for part in parts})


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """By module: nothing when it was imported, else the error."""
    ros.require(not missing(), f"Debian's packages lack {', '.join(missing())}")
    program = tmp_path_factory.mktemp("modules") / "imports.py"
    program.write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "-m", "rosproto", "run", str(program)],
        cwd=ROOT,
        input=json.dumps(modules()),
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])  # type: ignore[no-any-return]


def missing() -> list[str]:
    return [n for n in PACKAGES if not ((DEBIAN / n).is_dir() or (DEBIAN / f"{n}.py").is_file())]


def test_each_is_there_or_the_error_says_why_not(told: dict[str, str]) -> None:
    """A refusal is the sentence of this layer: the name, why, and what there is in its place."""
    refusal = re.compile(r"ModuleNotFoundError: No module named '(?P<name>[\w.]+)': .{20,}")
    odd = {}
    for name, text in told.items():
        found = refusal.fullmatch(text)
        if text and not (found and (name == found["name"] or name.startswith(found["name"] + "."))):
            odd[name] = text
    assert odd == {}


@pytest.mark.parametrize("page", ["rospy.md", "rospy.zh-CN.md"])
def test_the_page_has_their_number(told: dict[str, str], page: str) -> None:
    numbers = {len(told), sum(not text for text in told.values())}
    line = next(
        line
        for line in (ROOT / "docs" / page).read_text("utf-8").splitlines()
        if re.search(r"Debian.* \d{3} ", line)
    )
    assert {int(number) for number in re.findall(r"\d{3}", line)} == numbers
