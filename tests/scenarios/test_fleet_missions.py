"""A mission as an action of a fleet's order: `--action NAME=mission:FILE`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from tests.support.fleet_master import Master, errors, order_over, statuses
from tests.support.mosquitto import mosquitto
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
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


@pytest.mark.slow
@pytest.mark.timeout(120)
@pytest.mark.skipif(sys.platform == "win32", reason="mosquitto is tried on Linux and macOS")
def test_an_order_of_a_fleet_manager_carries_a_mission_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a real broker and `woosh vda5050`: the mission's end is the action's end, and cancelOrder ends both."""
    pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "long").mkdir()
    turn, watch = (
        file(tmp_path, "rotate", 'degrees = "$angle"'),
        file(tmp_path / "long", "wait", "seconds = 600"),
    )
    targets = [f"round={turn}", f"watch={watch}"]
    with (
        mosquitto(tmp_path) as broker,
        SimulatedChassis(speed=6, full_graph=False) as sim,
        Master(broker.port) as master,
        Chassis(sim.master_uri) as chassis,
    ):
        words = [
            "-m",
            "woosh_pure",
            "vda5050",
            "--master",
            sim.master_uri,
            "--broker",
            broker.url,
            "--map-id",
            "hall",
        ]
        words += ["--serial", "A-17", "--state", str(tmp_path / "orders")]
        words += [word for target in targets for word in ("--action", target)]
        env = {**os.environ, "PYTHONUNBUFFERED": "1"}
        with subprocess.Popen([sys.executable, *words], env=env, stdout=subprocess.DEVNULL) as command:
            try:
                master.until(lambda s: s["agvPosition"]["positionInitialized"], 30.0)
                master.send("order", order_over("one", "n1 n2", actions={"n2": [action("r", "round", 20)]}))
                done = master.until(lambda s: statuses(s).get("r") in ("FINISHED", "FAILED"), 40.0)
                assert (statuses(done)["r"], errors(done)) == ("FINISHED", [])
                run = chassis.missions.state.run
                assert run is not None
                assert (run.phase.value, run.entry.parameters) == ("done", {"angle": 20})
                master.until(lambda s: not s["nodeStates"])
                master.send("order", order_over("two", "n2 n1", actions={"n2": [action("w", "watch", 20)]}))
                master.until(lambda s: statuses(s).get("w") == "RUNNING", 30.0)
                until(lambda: chassis.missions.state.active, what="the mission")
                master.instant("c", "cancelOrder")
                ended = master.until(lambda s: statuses(s).get("c") in ("FINISHED", "FAILED"), 40.0)
                assert (statuses(ended)["c"], statuses(ended)["w"], ended["nodeStates"]) == (
                    "FINISHED",
                    "FAILED",
                    [],
                )
                run = chassis.missions.state.run
                assert run is not None
                assert run.phase.value == "stopped"
            finally:
                command.send_signal(signal.SIGINT)
                assert command.wait(20.0) in (0, 130)


def action(number: str, name: str, angle: int) -> dict[str, Any]:
    """An action of a node."""
    given = [{"key": "angle", "value": angle}]
    return {"actionId": number, "actionType": name, "blockingType": "HARD", "actionParameters": given}
