"""A chassis that is connected and refuses, fails and replies with words made for the terminal that shows them."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto.action.server import ServerGoal
from tests.support.hostile_peer import RAW, wrongs_of
from woosh_pure import Chassis, ChassisError, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.sim.tasks import TaskMachine, TaskReply

VERBS = [
    "goto A1", "goto --pose 1 0 0", "task pick A1", "task park --pose 1 0 0", "task carry A1 --load", "task pause --id 7",
    "task resume --id 7", "task cancel --id 7", "task interrupt-wait --id 7", "move 0.5", "rotate 20", "ready --listen 0.3", "status",
    "faults --listen 0.3", "stop",
]  # fmt: skip


@pytest.fixture(scope="module")
def refusing() -> Iterator[SimulatedChassis]:
    """Every task is refused, every action ends as aborted, both in RAW's words."""
    abort = ServerGoal.abort

    def refuse(self: TaskMachine, success: bool, message: str, code: int = 0) -> TaskReply:
        return TaskReply(False, RAW, 2)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(TaskMachine, "_reply", refuse)
        for end in ("abort", "succeed"):  # the robot could move: nothing is refused before it is asked
            patch.setattr(ServerGoal, end, lambda goal, result=None, text="": abort(goal, result, RAW))
        with SimulatedChassis(full_graph=False, speed=8.0) as sim:
            yield sim


@pytest.mark.promise("cannot control a terminal or forge a line")
@pytest.mark.parametrize("form", [[], ["--json"], ["--lang", "zh"]], ids=["plain", "json", "Chinese"])
@pytest.mark.parametrize("verb", VERBS)
def test_what_a_chassis_says_when_it_refuses(
    refusing: SimulatedChassis,
    verb: str,
    form: list[str],
    capfd: pytest.CaptureFixture[str],
    private_config: Path,
) -> None:
    """Standard output, standard error and the log on it."""
    main(["--chassis", refusing.master_uri, *form, *verb.split()])
    out, err = capfd.readouterr()
    assert wrongs_of(out) == []
    assert wrongs_of(err) == []
    if form == ["--json"]:
        json.loads(out)
    if verb.partition(" ")[0] in ("goto", "task", "move", "rotate"):
        assert "FORGED by a peer" in out + err  # it was shown


def test_the_error_and_the_log_of_a_program(
    refusing: SimulatedChassis, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    with Chassis(refusing.master_uri) as chassis:
        for begin in (lambda: chassis.go_to_mark("A1"), lambda: chassis.move(0.5)):
            try:
                shown = str(begin().wait(timeout=5.0))
            except ChassisError as error:
                shown = str(error)
            assert "FORGED by a peer" in shown
            assert wrongs_of(shown) == []
        assert wrongs_of(chassis.readiness().sentence()) == []
    written = map(logging.Formatter("%(levelname)s %(message)s").format, caplog.records)
    assert [line for line in written if wrongs_of(line)] == []
