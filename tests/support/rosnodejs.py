"""The npm client `rosnodejs` as a peer, installed into a cache outside this repository; any Node.js runs it.

Tests reach no other machine, so install it before: `python -m tests.support.rosnodejs`, as .ci/run does.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

from rosproto.codec import message_class
from rosproto.msg import split_full_text
from tests.support import ros
from tests.support.watched.plugin import CACHE

__all__ = ["install", "installed", "package_tree", "start"]

VERSION = "3.1.0"
PACKAGES = (
    "std_msgs", "std_srvs", "geometry_msgs", "sensor_msgs", "rosgraph_msgs", "actionlib_msgs", "actionlib", "roscpp",
)  # fmt: skip
ACTIONS = ("actionlib/Test",)
PARTS = ("Action", "ActionGoal", "ActionResult", "ActionFeedback", "Goal", "Result", "Feedback")


def _target() -> Path:
    cache = os.environ.get(CACHE) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "rosproto-tests" / f"rosnodejs-{VERSION}"


def installed() -> Path:
    """The directory with node_modules/rosnodejs; skips the running test if it is not installed."""
    ros.require(shutil.which("node"), "node is not installed")
    target = _target()
    if target.exists():
        with ros.exclusive(target / "lock"):  # another process may be installing it
            pass
    missing = f"rosnodejs {VERSION} is not installed: python -m tests.support.rosnodejs"
    ros.require((target / "done").exists(), missing)
    return target


def install() -> Path:
    """Install it from npm's registry; return the directory with node_modules/rosnodejs.

    Raises:
        RuntimeError: The installation failed; includes npm's message.
    """
    npm = shutil.which("npm")
    if npm is None:
        raise RuntimeError("npm is not installed")
    target = _target()
    target.mkdir(parents=True, exist_ok=True)
    with ros.exclusive(target / "lock"):
        if not (target / "done").exists():
            command = [
                npm, "install", "--prefix", str(target), "--no-audit", "--no-fund", "--no-save",
                "--ignore-scripts", f"rosnodejs@{VERSION}",
            ]  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, timeout=300)
            if done.returncode:
                raise RuntimeError(f"rosnodejs {VERSION} cannot be installed: {done.stderr[-500:]}")
            (target / "done").touch()
    return target


def package_tree(target: Path) -> Path:
    """Write packages with the definitions it needs, as in a workspace; for ROS_PACKAGE_PATH."""
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
    """Run JavaScript with `rosnodejs` and `nh`, a node handle of /js; use it in a `with` block.

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


if __name__ == "__main__":
    print(install())
