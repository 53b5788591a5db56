"""Fixtures of the scenarios: a simulated chassis over real TCP, faster than real time, and a Chassis on it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.robot_pool import RobotPool
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.firmware.versions import CURRENT

SPEED = 8.0


@pytest.fixture(scope="module")
def robots() -> Iterator[RobotPool]:
    """Simulated chassis without the parts of the graph that carry no content; one is used again and again.

    For the tests of a file: to start one costs less than to keep one for seconds in which nobody needs it.

    FIRMWARE=1.0.8 in the environment runs every scenario that uses these on an older one; test_firmwares.py does
    so with a representative part in every run. What it cannot be told is a FirmwareLimit then.
    """
    # The state is said on change, a status code once: the harder case.
    options = {"full_graph": False, "latch_status": False, "repeat_status_code": False}
    with RobotPool(**options, firmware=os.environ.get("FIRMWARE", CURRENT)) as pool:
        yield pool


@pytest.fixture
def sim(robots: RobotPool) -> Iterator[SimulatedChassis]:
    """A simulated chassis, as good as new, at 8 times real time."""
    robot = robots.take(SPEED)
    yield robot.sim
    robots.give_back(robot)


@pytest.fixture
def real_time(sim: SimulatedChassis) -> Callable[[], None]:
    """The simulated chassis in real time, for what happens in the middle of a motion; the function hurries it again.

    At 8 times real time a busy computer may come to the middle only after the end.
    """
    sim.speed = 1.0
    return lambda: setattr(sim, "speed", SPEED)


@pytest.fixture
def chassis(sim: SimulatedChassis) -> Iterator[Chassis]:
    """A Chassis connected to it."""
    with Chassis(sim.master_uri) as connected:
        yield connected


@pytest.fixture(name="until")
def waiting() -> Callable[..., None]:
    """Wait for a condition with a deadline."""
    return until


@pytest.fixture
def private_config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the commands keep things: no test of them reads or writes what the user has saved, or a master of the environment."""
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    return tmp_path / "config"


@pytest.fixture
def woosh(sim: SimulatedChassis, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run a verb on the simulated chassis; exit code, stdout, stderr."""

    def run(*words: str) -> tuple[int, str, str]:
        from woosh_pure.cli import main

        try:
            code = main(["--master", sim.master_uri, *words])
        except SystemExit as refused:  # by the parser
            code = int(str(refused.code))
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def document(woosh: Callable[..., tuple[int, str, str]]) -> Callable[..., tuple[int, Any]]:
    """Run a verb with --json at its end; the exit code and the document."""

    def run(*words: str) -> tuple[int, Any]:
        code, out, _ = woosh(*words, "--json")
        return code, json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))

    return run
