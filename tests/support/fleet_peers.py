"""Fleet managers of others, unmodified: `vda-5050-lib` (npm) and `vda5050-sdk` (PyPI), as peers of `woosh vda5050`.

They are looked for in `$FLEET_PEERS`, or else in the cache of these tests: a folder with `node_modules` and a `venv`.
`python -m tests.support.fleet_peers` makes it, as .ci/run does; tests reach no other machine.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.support import ros
from tests.support.watched.plugin import CACHE

__all__ = ["Manager", "install", "javascript", "python", "vehicle"]

NPM, PYPI = "vda-5050-lib@1.4.0", "vda5050-sdk[mqtt]==0.2.0"
ROOT = Path(__file__).resolve().parent.parent.parent


def _folder() -> Path:
    if given := os.environ.get("FLEET_PEERS"):
        return Path(given)
    cache = os.environ.get(CACHE) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "rosproto-tests" / "fleet-peers"


def install() -> Path:
    """Install both; the folder.

    Raises:
        RuntimeError: One cannot be installed; with the installer's words.
    """
    folder = _folder()
    folder.mkdir(parents=True, exist_ok=True)
    npm = [
        "npm",
        "install",
        "--prefix",
        str(folder),
        "--no-audit",
        "--no-fund",
        "--no-save",
        "--ignore-scripts",
        NPM,
    ]
    venv = [sys.executable, "-m", "venv", str(folder / "venv")]
    pip = [str(folder / "venv" / "bin" / "python"), "-m", "pip", "install", "-q", PYPI]
    for command in (npm, venv, pip):
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        if done.returncode:
            raise RuntimeError(f"{' '.join(command[:4])} ... failed: {done.stderr[-500:]}")
    return folder


class Manager:
    """A program that drives a vehicle, and prints its observations as lines of JSON.

    Attributes:
        said: The parsed lines.
    """

    def __init__(self, command: list[str], env: dict[str, str]) -> None:
        self.said: list[dict[str, Any]] = []
        self.noise: list[str] = []
        self.process = subprocess.Popen(
            command, env={**os.environ, **env}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def run(self, seconds: float) -> list[dict[str, Any]]:
        """Wait for its end; return its lines."""
        timer = threading.Timer(seconds, self.process.kill)
        timer.start()
        assert self.process.stdout is not None
        try:
            for line in self.process.stdout:
                if line.startswith("{"):
                    self.said.append(json.loads(line))
                else:
                    self.noise.append(line.rstrip())
            self.process.wait(10.0)
        finally:
            timer.cancel()
        assert self.process.returncode == 0, (self.process.returncode, self.noise[-20:], self.said[-5:])
        return self.said


def javascript(script: Path, **given: str) -> Manager:
    """Run a script of node with vda-5050-lib; the test is skipped where that is not installed."""
    ros.require(shutil.which("node"), "node is not installed")
    modules = _folder() / "node_modules"
    where = f"{NPM} is not in {modules} (or $FLEET_PEERS): python -m tests.support.fleet_peers"
    ros.require((modules / "vda-5050-lib").exists(), where)
    return Manager(["node", str(script)], {"NODE_PATH": str(modules), **given})


def python(script: Path, **given: str) -> Manager:
    """Run a script of Python with vda5050-sdk; the test is skipped where that is not installed."""
    interpreter = _folder() / "venv" / "bin" / "python"
    where = f"{PYPI} is not in {interpreter.parent} (or $FLEET_PEERS): python -m tests.support.fleet_peers"
    ros.require(interpreter.exists(), where)
    return Manager([str(interpreter), str(script)], {"PYTHONPATH": "", **given})


@contextmanager
def vehicle(
    broker: str, folder: Path, *options: str, speed: float = 3.0, config: Path | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Run `woosh vda5050` on a new simulated chassis, or by a fleet.toml; end it as a service manager does."""
    before, given = (
        ["--sim", "--sim-speed", str(speed)],
        ["--broker", broker, "--serial", "A-17", "--map-id", "hall"],
    )
    if config is not None:
        before, given = [], ["--config", str(config)]
    command = [
        sys.executable,
        "-m",
        "woosh_pure",
        *before,
        "vda5050",
        *given,
        "--state",
        str(folder),
        *options,
    ]
    log = folder / "vehicle.log"
    with log.open("a") as file:
        process = subprocess.Popen(command, cwd=ROOT, stdout=file, stderr=subprocess.STDOUT, text=True)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(20.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(10.0)
            raise


if __name__ == "__main__":
    print(install())
