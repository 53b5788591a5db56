"""Half an hour of a stranger, in order: the round of docs/missions.md, on a phone, with a server that is killed."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.support.browser import PHONE, person
from tests.support.ros import free_port
from tests.support.waiting import until
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]
PAGE = (Path(__file__).parents[2] / "docs" / "missions.md").read_text("utf-8")
CURRENT = "#mission .steps [aria-current]"


@contextmanager
def served(sim: SimulatedChassis, port: int, folder: Path) -> Iterator[subprocess.Popen[str]]:
    """`woosh web` for the robot, with the folder of missions; killed at the end."""
    words = ("--port", str(port), "--allow-driving", "--no-browser", "--missions", str(folder))
    process = woosh_process("--json", "--master", sim.master_uri, "web", *words)
    try:
        assert process.stdout is not None
        assert json.loads(process.stdout.readline())["port"] == port
        yield process
    finally:
        process.kill()  # as kill -9
        process.communicate(timeout=20)


def stood(sim: SimulatedChassis) -> bool:
    """Whether it has not moved for a second of its time."""
    before, end = sim.pose, sim.now + 1.0
    until(lambda: sim.now > end, 20.0)
    return sim.pose.distance_to(before) < 0.001


def test_the_walk_of_the_page(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write, check, start, watch, kill the server, start it again, resume, answer, end: nothing moves before the resume."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    folder = tmp_path / "missions"
    folder.mkdir()
    (file := folder / "round.mission.toml").write_text(text, "utf-8")
    words = [sys.executable, "-m", "woosh_pure", "mission", "check", str(file)]
    assert "Delivery round: 4 steps, no fault" in subprocess.check_output(words, text=True)
    port = free_port()
    with SimulatedChassis(speed=4) as sim:
        with served(sim, port, folder), person(browser, f"http://127.0.0.1:{port}", PHONE) as page:
            page.click("#tabbutton-missions")
            page.click("#missions .saved .primary")
            assert page.input_value("#parameter-target") == "B1"
            page.click("#confirm [type=submit]")
            page.wait_for_selector(f"{CURRENT} >> text=A1")
            start = sim.pose
            until(lambda: sim.pose.distance_to(start) > 0.3, 30.0)
        until(lambda: stood(sim), 30.0, "the stop by the watchdog")
        here = sim.pose
        with served(sim, port, folder), person(browser, f"http://127.0.0.1:{port}", PHONE) as page:
            page.wait_for_selector("#mission >> text=Interrupted by a restart")
            assert page.inner_text(CURRENT).endswith("A1")
            assert stood(sim)
            assert sim.pose.distance_to(here) < 0.01
            page.click("#mission-resume")
            page.wait_for_selector("#mission .question >> text=Step 1 was under way when the server ended")
            assert stood(sim)
            page.click("#mission >> text=Do it again")
            page.wait_for_selector("#mission .question >> text=Is it loaded?", timeout=60_000)
            assert sim.pose.distance_to(sim.marks["A1"]) < 0.1
            page.click("#mission fieldset >> text=yes")
            page.wait_for_selector("#mission .question", state="hidden")
            page.wait_for_selector("#mission", state="hidden", timeout=60_000)
            page.click("#tabbutton-missions")
            page.wait_for_selector("#mission-runs >> text=Done")
        assert sim.pose.distance_to(sim.marks["P1"]) < 0.1
        with Chassis(sim.master_uri, robot_api=False) as chassis:
            run = chassis.missions.state.run
        assert run is not None
        assert (run.phase.value, run.ended) == ("done", ((0, True), (2, True), (3, True)))
