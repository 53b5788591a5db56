"""The woosh command, as a person types it: output, exit codes, Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from woosh_pure.cli import main
from woosh_pure.cli.commands import COMMANDS
from woosh_pure.enums import TaskState

ROOT = Path(__file__).resolve().parents[2]


def woosh(*arguments: str) -> subprocess.Popen[str]:
    """Start the command in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    environment.pop("ROS_MASTER_URI", None)
    return subprocess.Popen(
        [sys.executable, "-m", "woosh_pure", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=environment,
    )


@pytest.mark.slow
@pytest.mark.example
def test_the_demo_drives_measures_and_ends_well():
    process = woosh("demo")
    out, err = process.communicate(timeout=100)
    assert process.returncode == 0, err
    for words in (
        "the battery has 87 %",
        "asked for 0.500 m, measured 0.",
        "asked for 90.0°, measured ",
        "drives to mark A1",
        "arrived, ",
        "done in ",
    ):
        assert words in out
    assert out.splitlines()[-1] == "next, a simulated robot in your browser: woosh --sim web"
    assert not re.search(r"task|code|\d{6}", out.replace(out.splitlines()[1], "")), (
        "words, but for the address"
    )
    assert err == ""


def test_the_demo_refuses_a_real_chassis(capsys):
    assert main(["demo", "--chassis", "169.254.128.2"]) == 2
    assert "only its own simulated chassis" in capsys.readouterr().err


def test_status_reads_any_chassis(sim, capsys):
    assert main(["--master", sim.master_uri, "status", "--wait", "20"]) == 0
    out = capsys.readouterr().out
    assert "87 %" in out
    assert "differential" in out
    assert main(["status", "--master", sim.master_uri, "--json", "--wait", "20"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["feeds"]["battery"]["value"]["percent"] == 87
    assert document["ready"] is None
    assert document["answer"] == "not known"


def test_without_an_address_the_error_says_what_to_give(monkeypatch, capsys):
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    assert main(["status"]) == 2
    assert "ROS_MASTER_URI is not set" in capsys.readouterr().err


def test_an_absent_master_is_one_clear_sentence(capsys):
    assert main(["--master", "http://127.0.0.1:1", "status"]) == 4
    err = capsys.readouterr().err
    assert "127.0.0.1:1" in err
    assert "refused" in err
    assert "Traceback" not in err


def test_moving_by_command(sim, capsys):
    uri = ["--master", sim.master_uri]
    assert main([*uri, "move", "0.3"]) == 0
    assert main([*uri, "rotate", "90", "--speed", "40"]) == 0
    assert sim.pose.x == pytest.approx(0.3, abs=0.02)
    assert sim.pose.yaw_degrees == pytest.approx(90.0, abs=1.0)
    assert main([*uri, "goto", "--pose", "1", "0", "0"]) == 0
    assert main([*uri, "goto", "P1"]) == 0
    assert "arrived" in capsys.readouterr().out


def test_a_wrong_number_is_refused_and_nothing_moves(sim, capsys):
    assert main(["--master", sim.master_uri, "move", "11"]) == 2
    assert "10.0 m" in capsys.readouterr().err
    assert sim.pose.x == 0.0


def test_an_unknown_mark_is_an_error(sim, capsys):
    assert main(["--master", sim.master_uri, "goto", "Z9"]) == 3
    assert "not known" in capsys.readouterr().err


def test_a_timeout_is_an_error_and_the_robot_stands(sim, real_time, capsys):
    assert main(["--master", sim.master_uri, "goto", "B1", "--timeout", "0.3"]) == 1
    assert "timed out" in capsys.readouterr().err
    assert sim.world.body.velocity.is_standing()


def test_stop_ends_what_somebody_else_started(sim, real_time, chassis, capsys):
    chassis.go_to_mark("B1")
    assert main(["--master", sim.master_uri, "stop"]) == 0
    assert "stands still" in capsys.readouterr().out
    assert sim.world.tasks.state is TaskState.CANCELLED


@pytest.mark.skipif(sys.platform == "win32", reason="sends a POSIX signal")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_and_sigterm_stop_the_motion(sim, real_time, until, number, code):
    process = woosh("--master", sim.master_uri, "goto", "B1")
    until(lambda: not sim.world.body.velocity.is_standing(), 20.0)
    process.send_signal(number)
    out, err = process.communicate(timeout=20)
    assert process.returncode == code, err
    assert "stands still" in out
    assert "Traceback" not in err
    assert sim.world.tasks.state is TaskState.CANCELLED
    assert sim.world.body.velocity.is_standing()


def test_the_simulator_runs_for_other_programs(capsys):
    assert main(["sim", "--port", "0", "--for", "0.2"]) == 0
    assert "woosh --master http://127.0.0.1:" in capsys.readouterr().out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_help(name, capsys):
    assert COMMANDS[name]
    with pytest.raises(SystemExit) as caught:
        main([name, "--help"])
    assert caught.value.code == 0
    assert name in capsys.readouterr().out


def test_no_command_prints_the_help(capsys):
    assert main([]) == 2
    assert "demo" in capsys.readouterr().err
