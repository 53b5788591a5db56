"""The original rosbridge_suite (branch ros1) as a peer: its server and rosapi, unchanged.

No registry has it, so `python -m tests.support.rosbridge_suite` downloads one commit from GitHub into the cache, as
.ci/run does; ROSBRIDGE_SUITE names another checkout. It runs on Debian's rospy with Debian's python3-autobahn and
python3-bson, or on our own layer (`rosproto run`).
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from tests.support import ros
from tests.support.git_snapshot import take
from tests.support.ports import unused_port
from tests.support.web_peers import cache

__all__ = ["build", "checkout", "install", "served"]

VARIABLE = "ROSBRIDGE_SUITE"
REPOSITORY = "https://github.com/RobotWebTools/rosbridge_suite.git"
COMMIT = "55a6bdb20842a3f7f0e17931b7856c3d8700f9fb"  # the last commit of branch ros1
PACKAGES = ("rosapi", "rosbridge_library", "rosbridge_msgs")
PROGRAMS = ("rosapi", "rosbridge_library", "rosbridge_server")
IMPORTS = ("rospy", "autobahn", "bson", "PIL", "tornado", "twisted", "rosservice", "rostopic", "rosnode")
ROSAUTH = """string mac
string client
string dest
string rand
time t
string level
time end
---
bool authenticated
"""  # the part of the separate package rosauth that rosbridge_server imports; facts of the wire


def _folder() -> Path:
    return cache() / f"rosbridge_suite-{COMMIT[:12]}"


def checkout() -> Path:
    """The checkout; skips the running test if there is none.

    With a checkout, Debian's packages that it imports are required, as for every peer (`ros.require`).
    """
    named = os.environ.get(VARIABLE)
    place = Path(named) if named else _folder()
    found = (place / "rosbridge_server" / "scripts").is_dir()
    if not named and not found:
        pytest.skip(
            f"rosbridge_suite is not here: `python -m tests.support.rosbridge_suite` gets it from GitHub, or {VARIABLE}"
            " names a checkout of branch ros1"
        )
    ros.require(found, f"{VARIABLE}={place} is not a checkout of rosbridge_suite, branch ros1")
    ros.require_ros(*IMPORTS)
    return place


def install() -> Path:
    """Download the commit from GitHub into the cache, unless it is there; return its folder.

    Raises:
        RuntimeError: The download failed; includes git's message.
    """
    target = _folder()
    target.parent.mkdir(parents=True, exist_ok=True)
    with ros.exclusive(target.with_suffix(".lock")):
        if not (target / "rosbridge_server").is_dir():
            begun = target.with_suffix(".begun")
            shutil.rmtree(begun, ignore_errors=True)
            take("rosbridge_suite", REPOSITORY, COMMIT, begun)
            begun.rename(target)
    return target


def build(place: Path, target: Path) -> Path:
    """Build the checkout as catkin does: code of its definitions, its Python packages, manifests.

    Args:
        place: The checkout.
        target: The output folder: `python` is for PYTHONPATH, `share` for ROS_PACKAGE_PATH.
    """
    definitions, python, share = target / "definitions", target / "python", target / "share"
    for package in PACKAGES:
        for kind in ("msg", "srv"):
            if (place / package / kind).is_dir():
                shutil.copytree(place / package / kind, definitions / package / kind)
    (definitions / "rosauth" / "srv").mkdir(parents=True)
    (definitions / "rosauth" / "srv" / "Authentication.srv").write_text(ROSAUTH)
    ros.generate_python_packages(python, definitions)
    for package in PROGRAMS:
        shutil.copytree(place / package / "src" / package, python / package, dirs_exist_ok=True)
    for package in {*PACKAGES, *PROGRAMS, "rosauth", *(p.name for p in ros.MSGDEFS.iterdir() if p.is_dir())}:
        (share / package).mkdir(parents=True)
        (share / package / "package.xml").write_text(
            f'<package format="2"><name>{package}</name><version>0.0.0</version><description>x</description>'
            '<maintainer email="x@example.org">x</maintainer><license>x</license></package>\n'
        )
    return target


@contextmanager
def served(
    place: Path, built: Path, master_uri: str, *, layer: bool = False, messages: Path | None = None
) -> Iterator[str]:
    """Run its WebSocket server and its rosapi; yield the URL.

    Args:
        place: The checkout.
        built: The result of `build`.
        master_uri: The master of both.
        layer: Run them by `rosproto run` on our rospy, with Debian's Python; else on Debian's rospy.
        messages: More generated messages, for PYTHONPATH.
    """
    port = unused_port()
    folders = [built / "python", *([messages] if messages else []), *([_ROOT] if layer else [])]
    environment = ros.environment(
        master_uri.rstrip("/"),
        packages=os.pathsep.join(map(str, folders)),
        extra={"ROS_PACKAGE_PATH": f"{built / 'share'}{os.pathsep}/usr/share"},
    )
    start = [ros.PYTHON, "-m", "rosproto", "run"] if layer else [ros.PYTHON]
    server = place / "rosbridge_server" / "scripts" / "rosbridge_websocket.py"
    with ExitStack() as stack:
        api = stack.enter_context(
            ros.RosProcess([*start, str(place / "rosapi" / "scripts" / "rosapi_node")], environment)
        )
        bridge = stack.enter_context(
            ros.RosProcess([*start, str(server), "--port", str(port), "--address", "127.0.0.1"], environment)
        )
        _wait_for_port(port, bridge)
        api.wait_for("Rosapi started")
        yield f"ws://127.0.0.1:{port}"


def _wait_for_port(port: int, process: ros.RosProcess, timeout: float = 60.0) -> None:
    end = time.monotonic() + timeout
    while process.running and time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            return
        except OSError:
            time.sleep(0.05)
    raise AssertionError(f"rosbridge_suite does not serve within {timeout} s:\n{process.output}")


_ROOT = Path(__file__).resolve().parents[2]


if __name__ == "__main__":
    try:
        print(install())
    except (OSError, RuntimeError, subprocess.TimeoutExpired) as problem:
        sys.exit(str(problem))
