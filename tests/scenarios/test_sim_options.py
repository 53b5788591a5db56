"""`woosh sim` and `woosh run --sim` with marks of one's own, and the status code that is said again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from woosh_pure import Chassis, OutcomeKind, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.enums import RobotState
from woosh_pure.faults import FaultLevel
from woosh_pure.maps.marks import MarkFile
from woosh_pure.sim import Settings

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import actionlib, rospy, sys
from woosh_msgs.srv import ExecTask, ExecTaskRequest
rospy.init_node("program")
rospy.wait_for_service("/exec_task", 10)
call = rospy.ServiceProxy("/exec_task", ExecTask)
print([call(ExecTaskRequest(task_exect=1, task_id=1, task_type=3, mark_no=name)).success for name in sys.argv[1:]])
"""


def test_a_task_drives_to_a_mark_of_the_command_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """By option and by file."""
    marks = MarkFile(tmp_path / "list.json")
    marks.put("货架", pose=None)
    marks.save()
    assert main(["marks", "--file", str(tmp_path / "list.json"), "add", "架", "--pose", "2", "0", "90"]) == 0
    reached: list[float] = []
    started = SimulatedChassis.start

    def start(self: SimulatedChassis) -> SimulatedChassis:
        started(self)
        with Chassis(self.master_uri) as chassis:
            for name in ("N", "架"):
                chassis.go_to_mark(name).wait(timeout=20)
                reached.append(round(self.pose.yaw_degrees / 10) * 10)
        return self

    monkeypatch.setattr(SimulatedChassis, "start", start)
    words = ["--mark", "N=1,0.5,-90", "--marks", str(tmp_path / "list.json"), "--speed", "10", "--port", "0"]
    assert main(["sim", *words, "--for", "0"]) == 0
    assert reached == [-90, 90]
    assert "架, N" in capsys.readouterr().out


@pytest.mark.parametrize("words", [["--mark", "N=1,2"], ["--mark", "N=-9,0,0"]], ids=["form", "wall"])
def test_a_wrong_mark_is_wrong_use(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sim", "--port", "0", "--for", "0", *words]) == 2
    assert "--mark N=" in capsys.readouterr().err


@pytest.mark.whole
def test_programs_for_rospy_have_their_marks(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)

    def run(*options: str, command: str = "woosh_pure") -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", command, "run", *options, str(tmp_path / "program.py"), "HERE", "NOWHERE"],
            env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip

    done = run("--sim", "--mark", "HERE=1,0,0")
    assert done.stdout.strip() == "[True, False]", done.stderr
    marks = str(tmp_path / "list.json")
    assert main(["marks", "--file", marks, "add", "NOWHERE", "--pose", "1", "0", "0"]) == 0
    done = run("--sim", "--marks", marks)
    assert done.stdout.strip() == "[False, True]", done.stderr
    wrong = run("--sim", "--mark", "HERE")
    assert wrong.returncode == 2
    assert "NAME=X,Y,YAW" in wrong.stderr
    alone = run("--mark", "HERE=1,0,0")
    assert alone.returncode == 2
    for options in (["--sim"], ["--mark", "HERE=1,0,0", "--sim"]):
        moved = run(*options, command="rosproto")
        assert (moved.returncode, moved.stdout) == (2, "")
        assert "woosh run --sim program.py" in moved.stderr
    assert "--sim" in alone.stderr


def codes_of(sim: SimulatedChassis, least: int) -> list[int]:
    """What somebody hears who has just subscribed."""
    heard: list[int] = []
    enough = threading.Event()
    with Chassis(sim.master_uri) as chassis:

        def hear(code: object) -> None:
            heard.append(code.code)  # type: ignore[attr-defined]
            if len(heard) >= least:
                enough.set()

        chassis.status_code.on(hear)
        enough.wait(4.0 if least else 1.6)
    return heard


def test_who_has_just_subscribed_hears_the_last_status_code() -> None:
    """Within a second and again and again, at whatever speed; the newest one after something has happened."""
    with SimulatedChassis(full_graph=False, speed=8) as sim:
        assert codes_of(sim, 2) == [140200000000] * 2
        sim.press_emergency_stop()
        heard = codes_of(sim, 2)
        assert len(set(heard)) == 1
        sim.release_emergency_stop()
        with Chassis(sim.master_uri) as chassis:
            assert chassis.status_code.wait(4.0).level is FaultLevel.NORMAL
            assert chassis.faults == ()


def test_one_without_its_position_says_so() -> None:
    with SimulatedChassis(full_graph=False, settings=Settings(located=False)) as sim:
        assert codes_of(sim, 1) == [140201000022]


def test_a_status_code_can_be_said_once(until: Callable[..., None]) -> None:
    """As it was: the harder case, of which nobody knows whether the real one is it."""
    with SimulatedChassis(full_graph=False, repeat_status_code=False) as sim:
        sim.press_emergency_stop()
        until(lambda: not sim.world._reports)  # it has been said, to nobody
        assert codes_of(sim, 0) == []


def test_the_option_of_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[object] = []

    class Noted(SimulatedChassis):
        def __init__(self, **options: object) -> None:
            seen.append(options["repeat_status_code"])
            super().__init__(**options)  # type: ignore[arg-type]

    monkeypatch.setattr("woosh_pure.sim.SimulatedChassis", Noted)
    for words in ([], ["--status-code-once"]):
        assert main(["sim", "--port", "0", "--for", "0", "--json", *words]) == 0
        assert "A1" in json.loads(capsys.readouterr().out)["marks"]
    assert seen == [True, False]


def test_a_reset_ends_goals_as_failures_and_gives_the_robot_of_the_start(sim, chassis, until) -> None:
    """The client hears the end of its task, then the state of a robot that is ready again."""
    start = sim.pose
    task = chassis.go_to_mark("B1")
    until(lambda: sim.pose.x > 0.3)
    sim.press_emergency_stop()
    sim.add_obstacle(4.0, 0.0)
    sim.slow_network(0.2)
    sim.reset()
    assert task.wait(10.0, raises=False).kind is OutcomeKind.FAILED
    assert sim.pose == start
    assert chassis.wait_until_ready(10.0, known=True)
    assert chassis.faults.present is False
    step = chassis.move(0.5)
    until(lambda: sim.pose.x > 0.1)
    sim.reset()
    assert step.wait(10.0, raises=False).kind is OutcomeKind.FAILED
    assert chassis.go_to(1.0, 0.0).wait(20.0)


def test_a_reset_ends_what_holds_the_network_up(sim, chassis) -> None:
    """Nobody waits for the end of a link that was interrupted for long."""
    assert chassis.battery.wait(5.0)
    sim.drop_link(300.0)
    sim.fall_silent(300.0)
    sim.set_clock(100.0)
    sim.reset()
    assert chassis.battery.wait(5.0).percent == 87
    assert abs(sim.now - time.time()) < 50.0


def test_a_reset_is_told_while_the_simulated_time_stands(sim, chassis) -> None:
    """Speed 0 is a pause: the faults and `reset` are taken, and the robot goes on with any other speed."""
    with pytest.raises(ValueError, match=r"0\.05 to 100"):
        sim.speed = -1.0
    chassis.wait_until_ready(10.0)
    sim.press_emergency_stop()
    chassis.wait_until(lambda status: status.robot_state is RobotState.FAULT, 20.0)
    sim.speed = 0.0
    before = sim.world.time
    sim.reset()
    chassis.wait_until(lambda status: status.robot_state is RobotState.IDLE, 20.0)
    assert sim.world.time == before
    sim.speed = 8.0
    chassis.wait_until_ready(10.0)  # the state and the code of the button come on two topics
    assert chassis.go_to(1.0, 0.0).wait(20.0)


def test_a_robot_that_was_carried_says_where_it_is(sim, chassis) -> None:
    """Its task fails, and its own estimate follows."""
    task = chassis.go_to_mark("B1")
    place = sim.marks["A2"]
    sim.teleport(place.x, place.y, place.yaw)
    assert task.wait(10.0, raises=False).kind is OutcomeKind.FAILED
    assert chassis.pose.wait_for(lambda pose: pose.distance_to(place) < 0.05, 5.0)
    assert chassis.go_to_mark("A2").wait(20.0)
    with pytest.raises(ValueError, match="in a wall"):
        sim.teleport(-9.0, 0.0)
    sim.set_battery(7)
    assert chassis.battery.wait_for(lambda battery: battery.percent == 7, 5.0)
    with pytest.raises(ValueError, match="0 to 100"):
        sim.set_battery(101)


@pytest.mark.parametrize("fault", ["teleport:-9:0", "battery:101", "teleport:1", "battery:full"])
def test_a_fault_that_cannot_be_is_wrong_use(fault: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sim", "--port", "0", "--for", "0.2", "--at", f"0={fault}"]) == 2
    assert fault in capsys.readouterr().err
