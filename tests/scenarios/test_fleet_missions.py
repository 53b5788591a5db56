"""A mission as an action of a fleet's order: `--action NAME=mission:FILE`."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from tests.support.waiting import until
from woosh_pure import Chassis
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers.custom_actions import handler_of
from woosh_pure.fleet.action_handlers.running_action import Task
from woosh_pure.fleet.drive_runner import DrivingLease
from woosh_pure.fleet.messages.elements import Action

TEXT = 'mission = 1\nname = "Round"\nparameters = { angle = 10 }\nguards = { not_known = "go" }\n[[step]]\ndo = "{do}"\n{key}\n'


@pytest.fixture
def task(chassis: Chassis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Task:
    """An action that begins."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    action = Action(id="a1", type="round", blocking="HARD", parameters={"angle": 20})
    return Task(action, chassis, [])


def file(folder: Path, do: str, key: str) -> str:
    path = folder / "round.mission.toml"
    path.write_text(TEXT.replace("{do}", do).replace("{key}", key))
    return f"mission:{path}"


def test_an_action_carries_a_mission_out_with_its_parameters(
    task: Task, chassis: Chassis, tmp_path: Path
) -> None:
    handler = handler_of("round", file(tmp_path, "rotate", 'degrees = "$angle"'))
    assert getattr(handler, "moves", False), "the order waits with its drives"
    handler(task)
    run = chassis.missions.state.run
    assert run is not None
    assert (run.phase.value, run.entry.parameters) == ("done", {"angle": 20})


def test_a_faulty_mission_is_refused_at_the_start(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="line 6"):
        handler_of("round", file(tmp_path, "fly", ""))


def test_the_lease_of_a_mission_of_the_order_is_not_that_of_a_local_driver(
    task: Task, chassis: Chassis, tmp_path: Path
) -> None:
    """Else the vehicle would become MANUAL, and its order would be dropped. The end of the action ends the mission."""
    lease = DrivingLease(chassis, "s1", {})
    assert chassis.lease.acquire("fleet manager of s1")
    ended: list[str] = []

    def work() -> None:
        with pytest.raises(ChassisError, match="cancelled"):
            handler_of("round", file(tmp_path, "wait", "seconds = 600"))(task)
        ended.append("cancelled")

    worker = threading.Thread(target=work, daemon=True)
    worker.start()
    until(lambda: chassis.lease.holder == "mission Round", what="the lease of the mission")
    assert lease.local_driver == ""
    task.cancelled.set()
    until(lambda: ended, what="the end of the action")
    run = chassis.missions.state.run
    assert run is not None
    assert run.phase.value == "stopped"
    chassis.missions.run(run.entry.mission, by="anna")
    until(lambda: chassis.lease.holder == "mission Round", what="the lease of hers")
    assert lease.local_driver == "mission Round"
    chassis.missions.stop()
