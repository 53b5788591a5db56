"""The npm client `rosnodejs` as a peer: installed into a cache outside this repository, run by Debian's or any node."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

from rosproto.codec import message_class
from rosproto.msg import split_full_text
from tests.support import ros

__all__ = ["install", "package_tree", "start"]

VERSION = "3.1.0"
PACKAGES = (
    "std_msgs", "std_srvs", "geometry_msgs", "sensor_msgs", "rosgraph_msgs", "actionlib_msgs", "actionlib", "roscpp",
)  # fmt: skip
ACTIONS = ("actionlib/Test",)
PARTS = ("Action", "ActionGoal", "ActionResult", "ActionFeedback", "Goal", "Result", "Feedback")


def install() -> Path:
    """The directory with node_modules/rosnodejs; the running test is skipped where node, npm or the registry is absent."""
    npm, node = shutil.which("npm"), shutil.which("node")
    ros.require(npm and node, "node and npm are not installed")
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    target = cache / "rosproto-tests" / f"rosnodejs-{VERSION}"
    target.mkdir(parents=True, exist_ok=True)
    with ros.exclusive(target / "lock"):
        if not (target / "done").exists():
            command = [
                str(npm), "install", "--prefix", str(target), "--no-audit", "--no-fund", "--no-save",
                "--ignore-scripts", f"rosnodejs@{VERSION}",
            ]  # fmt: skip
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=300)
                problem = done.stderr[-500:] if done.returncode else ""
            except subprocess.TimeoutExpired:
                problem = "npm took longer than 300 s"
            ros.require(not problem, f"rosnodejs {VERSION} cannot be installed: {problem}")
            (target / "done").touch()
    return target


def package_tree(target: Path) -> Path:
    """Packages with the definitions of ours that it needs, as a workspace has them; for ROS_PACKAGE_PATH."""
    for package in PACKAGES:
        folder = target / package
        for kind in ("msg", "srv"):
            for file in (ros.MSGDEFS / package / kind).glob(f"*.{kind}"):
                (folder / kind).mkdir(parents=True, exist_ok=True)
                shutil.copy(file, folder / kind)
        (folder / "msg").mkdir(parents=True, exist_ok=True)
        (folder / "package.xml").write_text(f"<package><name>{package}</name></package>\n")
    for action in ACTIONS:
        for part in PARTS:
            name = action + part
            text = split_full_text(message_class(name)._full_text, name)[name]
            (target / action.partition("/")[0] / "msg" / f"{name.partition('/')[2]}.msg").write_text(text)
    return target


def start(
    script: str, master_uri: str, installed: Path, tree: Path, extra: Mapping[str, str] | None = None
) -> ros.RosProcess:
    """Run JavaScript in which `rosnodejs` and `nh`, a node handle of /js, are there; to be used in a `with`.

    `say(value)` writes a line of JSON for the test.
    """
    program = (
        "const rosnodejs = require('rosnodejs');\n"
        "const say = value => console.log(JSON.stringify(value));\n"
        "process.on('unhandledRejection', e => { console.log('FAILED', e); process.exit(1); });\n"
        "rosnodejs.initNode('/js', {onTheFly: true, timeout: 20000}).then(async nh => {\n"
        f"{script}\n}}).catch(e => {{ console.log('FAILED', e); process.exit(1); }});\n"
    )
    env = {"CMAKE_PREFIX_PATH": str(tree), "ROS_PACKAGE_PATH": str(tree), **(extra or {})}
    env["NODE_PATH"] = str(installed / "node_modules")
    return ros.RosProcess(
        [str(shutil.which("node")), "-e", program], ros.environment(master_uri.rstrip("/"), extra=env)
    )
