"""Every verb of `woosh` against a simulated chassis: what it does, prints, writes, and its exit code."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.png import read_png
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.cli.registry import COMMANDS
from woosh_pure.enums import LedState, NavigationMode, RobotMode, TaskState
from woosh_pure.geometry import Pose2D
from woosh_pure.gridmap import GridMap
from woosh_pure.marks import MarkFile

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def private_config(tmp_path, monkeypatch):
    """No test reads or writes what the user has saved, or a master of the environment."""
    monkeypatch.setenv("WOOSH_CONFIG_DIR", str(tmp_path / "config"))
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    return tmp_path / "config"


@pytest.fixture
def woosh(sim, capsys):
    """Run a verb on the simulated chassis; exit code, stdout, stderr."""

    def run(*words: str) -> tuple[int, str, str]:
        code = main(["--master", sim.master_uri, *words])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def document(woosh):
    """Run a verb with --json at its end; the exit code and the document."""

    def run(*words: str):
        code, out, _ = woosh(*words, "--json")
        return code, json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))

    return run


def has(pixels: np.ndarray, color: tuple[int, int, int]) -> bool:
    return bool((pixels == color).all(axis=2).any())


# -- which chassis -------------------------------------------------------------------------------------------


def test_connect_remembers_a_chassis_that_answers(sim, capsys, private_config):
    address = sim.master_uri.removeprefix("http://").rstrip("/")
    assert main(["connect", "--show"]) == 1
    assert main(["connect", address, "--host", "127.0.0.1"]) == 0
    assert main(["connect", "--show", "--json"]) == 0
    out = capsys.readouterr().out
    shown = json.loads(out[out.index("{") :])
    assert shown["chassis"] == address
    assert shown["host"] == "127.0.0.1"
    assert Path(shown["file"]).parent == private_config
    assert main(["battery"]) == 0  # without any address
    assert "87 %" in capsys.readouterr().out
    assert main(["connect", "--forget"]) == 0
    assert main(["connect", "--forget", "--json"]) == 0
    assert '"forgotten": false' in capsys.readouterr().out
    assert main(["battery"]) == 2


def test_connect_saves_nothing_that_it_cannot_reach(capsys):
    assert main(["connect", "127.0.0.1:1"]) == 4
    assert "nothing was saved" in capsys.readouterr().err
    assert main(["connect", "--show"]) == 1
    assert main(["connect", "127.0.0.1:1", "--unchecked"]) == 0
    assert main(["connect", "--show"]) == 0
    assert "127.0.0.1:1" in capsys.readouterr().out


def test_the_environment_goes_before_the_saved_chassis_and_options_before_both(sim, capsys, monkeypatch):
    assert main(["connect", "127.0.0.1:1", "--unchecked"]) == 0
    assert main(["battery"]) == 4
    monkeypatch.setenv("ROS_MASTER_URI", sim.master_uri)
    assert main(["battery"]) == 0
    assert main(["battery", "--master", "http://127.0.0.1:2"]) == 4
    assert main(["battery", "--chassis", "127.0.0.1:2"]) == 4


def test_a_broken_profile_is_told_by_name(private_config, capsys):
    private_config.mkdir()
    (private_config / "profile.json").write_text("[]")
    assert main(["battery"]) == 2
    assert "profile.json" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["connect"],
        ["connect", "10.0.0.1", "--show"],
        ["connect", "--sim", "--show"],
        ["connect", "not an address"],
        ["battery", "--sim", "--master", "http://127.0.0.1:1"],
        ["battery", "--chassis", "a", "--master", "http://127.0.0.1:1"],
        ["battery", "--sim-speed", "2", "--master", "http://127.0.0.1:1"],
        ["faults", "--code", "-1"],
        ["scan", "--map"],
        ["say", " "],
        ["led", "blinking"],
        ["led", "idle", "--color", "orange"],
        ["footprint", "--points", "1,1 -1,1"],
        ["footprint", "--points", "1;1 2;2 3;3"],
        ["footprint", "--points", "1,1 2,1 2,2"],
        ["footprint", "--circle", "-1"],
        ["task", "pick"],
        ["goto"],
        ["goto", "A1", "--pose", "1", "2", "3"],
        ["watch", "--rate", "1000"],
        ["drive"],
        ["drive", "--json"],
        ["shell", "--json"],
        ["map", "set", "nothing.txt"],
        ["map", "save", "no/such/folder/out"],
    ],
)
def test_wrong_use_is_exit_code_2_or_a_missing_file_and_one_sentence(words, capsys, tmp_path, monkeypatch):
    """Nothing is asked of any chassis: none is given."""
    monkeypatch.chdir(tmp_path)
    expected = 1 if words[:2] == ["map", "set"] else 2
    assert main(words) == expected
    err = capsys.readouterr().err
    assert err.startswith(f"woosh: {words[0]}: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    "words",
    [
        ["fly"],
        ["move"],
        ["move", "far"],
        ["move", "nan"],
        ["plan", "1", "2"],
        ["plan", "inf", "0", "0"],
        ["task"],
        ["task", "carry", "A1"],
        ["map"],
        ["mode", "fast"],
        ["costmap", "maybe"],
        ["footprint"],
        ["footprint", "--circle", "1", "--rectangle", "1", "1"],
        ["battery", "--volume"],
        ["battery", "--wait", "0"],
        ["imu", "-n", "0"],
        ["goto", "A1", "--timeout", "-1"],
        ["move", "1", "--speed", "-1"],
        ["sim", "--port", "99999"],
        ["scan", "--png", "no/such/folder/scan.png"],
        ["completion", "tcsh"],
        ["localization", "pose", "1"],
    ],
)
def test_what_argparse_refuses_is_exit_code_2(words, capsys):
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == 2
    usage, sentence = capsys.readouterr().err.splitlines()
    assert usage.startswith("usage: woosh")
    assert sentence.startswith("woosh")
    assert sentence.endswith("--help")


def test_a_word_mistyped_is_answered_by_what_is_near_it(capsys):
    for words, hint in (
        (["stauts"], "did you mean status?"),
        (["task", "puase"], "did you mean pause?"),
        (["status", "--wiat", "3"], "did you mean --wait?"),
        (["costmap", "clera"], "did you mean clear?"),
    ):
        with pytest.raises(SystemExit):
            main(words)
        assert hint in capsys.readouterr().err


def test_a_failure_explains_its_code_and_speaks_of_commands(woosh):
    """What the API says to programmers is put in the words of the command line."""
    code, _, err = woosh("move", "0.1", "--left")  # a base that cannot go sideways
    assert code == 1
    assert "status code 120301000032 (step control: command not reachable)" in err
    assert "see `woosh ready` and `woosh faults`" in err
    assert "chassis." not in err


def test_leaving_the_shell_by_a_text_is_an_error_as_in_python(woosh):
    code, _, err = woosh("shell", "-c", "raise SystemExit('bye')")
    assert (code, err) == (1, "bye\n")


def test_definitions_of_the_environment_are_used(woosh, monkeypatch, tmp_path):
    """$ROSPROTO_MSG_PATH, as `rosproto` and `rosproto run` read it."""
    (tmp_path / "pkg" / "msg").mkdir(parents=True)
    (tmp_path / "pkg" / "msg" / "Depth.msg").write_text("float64 depth\n")
    monkeypatch.setenv("ROSPROTO_MSG_PATH", str(tmp_path / "pkg"))
    assert woosh("battery")[0] == 0
    monkeypatch.setenv("ROSPROTO_MSG_PATH", str(tmp_path / "nothing"))
    code, _, err = woosh("battery")
    assert code == 1
    assert "is not a folder" in err


def test_wrong_use_is_json_too(capsys):
    with pytest.raises(SystemExit):
        main(["battery", "--volume", "--json"])
    assert json.loads(capsys.readouterr().out)["exit_code"] == 2


def test_an_error_is_json_too(capsys):
    assert main(["battery", "--json", "--master", "http://127.0.0.1:1"]) == 4
    document = json.loads(capsys.readouterr().out)
    assert document["ok"] is False
    assert document["exit_code"] == 4
    assert "127.0.0.1:1" in document["error"]


def test_debug_shows_the_traceback(capsys):
    from rosproto.errors import ConnectionLost

    with pytest.raises(ConnectionLost):
        main(["battery", "--debug", "--master", "http://127.0.0.1:1"])


def test_sim_needs_no_address(capsys):
    assert main(["battery", "--sim", "--sim-speed", "5", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["percent"] == 87


# -- reading -------------------------------------------------------------------------------------------------


def woosh_process(*words: str) -> subprocess.Popen[str]:
    """The command in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-u", "-m", "woosh_pure", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
    )


def until_it_ends(process: subprocess.Popen[str], happen: Callable[[int], object]) -> str:
    """Let something happen again and again until the command has ended; its stdout."""
    for turn in range(300):
        if process.poll() is not None:
            break
        happen(turn)
        time.sleep(0.1)
    return process.communicate(timeout=20)[0]


def test_ready_says_yes(document):
    code, facts = document("ready")
    assert (code, facts["ready"]) == (0, True)


def test_ready_says_no_and_why(sim):
    """The mode is told on change only, so it changes until it is heard."""
    process = woosh_process("ready", "--master", sim.master_uri, "--listen", "20", "--json")
    modes = (RobotMode.MANUAL, RobotMode.MAINTENANCE)
    facts = json.loads(until_it_ends(process, lambda turn: sim.set_mode(modes[turn % 2])))
    assert process.returncode == 3
    assert facts["ready"] is False
    assert "manual_mode" in [reason["key"] for reason in facts["reasons"]]


def test_ready_waits(woosh):
    code, out, _ = woosh("ready", "--wait", "5")
    assert code == 0
    assert "ready" in out


def test_battery_with_a_threshold(woosh, document):
    code, facts = document("battery")
    assert code == 0
    assert facts["percent"] == 87
    assert facts["charge_status"] == "NOT_CHARGING"
    assert woosh("battery", "--below", "90")[0] == 1
    assert woosh("battery", "--below", "50")[0] == 0


def test_faults_are_told_and_codes_explained(sim, woosh, document, until):
    code, out, _ = woosh("faults", "--listen", "0.3")
    assert code == 0
    assert "no fault was heard" in out
    code, facts = document("faults", "--code", "110201000013")
    assert facts[0]["level"] == "SEVERE"
    assert woosh("faults", "--find", "emergency")[0] == 0
    assert woosh("faults", "--find", "no such words")[0] == 1
    assert "急停" in woosh("faults", "--code", "110201000013", "--chinese")[1]


def test_an_active_fault_is_exit_code_1(sim):
    process = woosh_process("faults", "--master", sim.master_uri, "--listen", "3")
    out = until_it_ends(process, lambda _: sim.report(110201000013))
    assert process.returncode == 1
    assert "emergency stop" in out


def test_imu_once_and_often(woosh, document):
    code, facts = document("imu")
    assert code == 0
    assert facts["linear_acceleration"][2] == pytest.approx(9.81, abs=0.1)
    code, out, _ = woosh("imu", "-n", "3", "--json")
    assert code == 0
    assert len([json.loads(line) for line in out.splitlines()]) == 3
    assert "yaw" in woosh("imu")[1]


def test_scan_in_words_json_and_pictures(sim, woosh, document, tmp_path):
    assert "ahead" in woosh("scan")[1]
    code, facts = document("scan", "--png", str(tmp_path / "scan.png"))
    assert code == 0
    assert len(facts["ranges"]) == 360
    assert facts["nearest"]["ahead"] > 0.5
    pixels = read_png((tmp_path / "scan.png").read_bytes())
    assert has(pixels, (240, 130, 0))
    assert has(pixels, (220, 30, 30))
    assert woosh("scan", "--map", "--png", str(tmp_path / "map.png"))[0] == 0
    assert read_png((tmp_path / "map.png").read_bytes()).shape == (320, 480, 3)


def test_camera_in_colour_and_depth(woosh, document, tmp_path):
    code, facts = document("camera", "--png", str(tmp_path / "color.png"))
    assert (code, facts["encoding"]) == (0, "rgb8")
    assert read_png((tmp_path / "color.png").read_bytes()).shape == (facts["height"], facts["width"], 3)
    code, facts = document("camera", "--depth", "--png", str(tmp_path / "depth.png"))
    depth = read_png((tmp_path / "depth.png").read_bytes())
    assert depth.dtype == ">u2"
    assert depth[depth > 0].min() == pytest.approx(facts["nearest"] * 1000, abs=60)
    assert "rgb8" in woosh("camera")[1]


def test_cloud_as_ply(woosh, document, tmp_path):
    _code, facts = document("cloud", "--ply", str(tmp_path / "c.ply"))
    data = (tmp_path / "c.ply").read_bytes()
    head, body = data.split(b"end_header\n", 1)
    assert f"element vertex {facts['points']}".encode() in head
    points = np.frombuffer(body, "<f4").reshape(-1, 3)
    assert len(points) == facts["points"] > 100
    assert points.min(axis=0) == pytest.approx(facts["low"], abs=1e-5)
    assert woosh("cloud", "--obstacles")[0] == 0


def test_watch_by_line_and_as_json_lines(woosh):
    code, out, _ = woosh("watch", "--for", "0.6", "--rate", "5", "--lines")
    assert code == 0
    assert "yaw" in out
    code, out, _ = woosh("watch", "--for", "0.8", "--rate", "5", "--json", "--no-map")
    documents = [json.loads(line) for line in out.splitlines()]
    assert len(documents) >= 2
    assert documents[-1]["pose"]["x"] == pytest.approx(0.0, abs=0.01)


# -- moving --------------------------------------------------------------------------------------------------


def test_task_kinds(sim, woosh, document):
    code, facts = document("task", "pick", "A1", "--type-number", "3", "--custom", "4")
    assert (code, facts["outcome"], facts["ok"]) == (0, "arrived", True)
    assert sim.pose.distance_to(sim.world.site.marks["A1"].pose) < 0.1
    assert woosh("task", "park", "P1")[0] == 0
    assert woosh("task", "carry", "A1", "--load")[0] == 0
    assert woosh("task", "pick", "--pose", "1", "0", "0", "--pose", "2", "0.5", "90")[0] == 0
    assert sim.pose.yaw_degrees == pytest.approx(90, abs=3)


def test_charge_ends_on_the_charger(document):
    code, facts = document("charge", "C1")
    assert code == 0
    assert facts["battery"]["charge_status"] == "CHARGING"


def test_a_running_task_is_paused_resumed_and_cancelled(sim, chassis, woosh, document, until):
    handle = chassis.go_to_mark("B1")
    number = str(handle.task_id)
    until(lambda: handle.state is TaskState.RUNNING)
    assert document("task", "pause", "--id", number)[0] == 0
    until(lambda: handle.state is TaskState.PAUSED)
    assert woosh("task", "resume", "--id", number)[0] == 0
    until(lambda: handle.state is TaskState.RUNNING)
    assert woosh("task", "cancel", "--id", number)[0] == 0
    assert handle.wait(10, raises=False).kind.value == "replaced" or handle.done
    assert woosh("task", "cancel", "--id", "1")[0] == 3
    code, _, err = woosh("task", "cancel")
    assert code == 1
    assert "--id" in err


def test_a_wait_is_interrupted(sim, chassis, woosh, until):
    handle = chassis.go_to_mark("W1")
    until(lambda: handle.state is TaskState.WAITING_FOR_ACTION, 20)
    assert woosh("task", "interrupt-wait", "--id", str(handle.task_id))[0] == 0
    assert handle.wait(10).arrived


def test_a_task_that_fails_and_one_that_is_late(sim, woosh):
    sim.fail_task("gripper jammed")
    code, _, err = woosh("task", "pick", "A1")
    assert code == 1
    assert "gripper jammed" in err
    code, _, err = woosh("task", "pick", "B1", "--timeout", "0.3")
    assert code == 1
    assert "timed out" in err
    assert sim.world.body.velocity.is_standing()


def test_goto_move_rotate_as_json(sim, document):
    assert document("goto", "--pose", "1", "0", "90")[1]["pose"]["x"] == pytest.approx(1.0, abs=0.1)
    assert document("move", "0.2", "--speed", "0.5")[1]["outcome"] == "arrived"
    assert document("rotate", "-45", "--speed", "60")[1]["ok"] is True


def test_a_failed_goal_is_json_too(sim, document):
    code, facts = document("goto", "Z9")
    assert code == 3
    assert facts["ok"] is False


# -- map and navigation --------------------------------------------------------------------------------------


def test_map_save_writes_what_map_server_reads_and_a_picture(sim, chassis, woosh, document, tmp_path):
    handle = chassis.go_to_mark("B1")  # there is a path to draw
    code, facts = document("map", "save", str(tmp_path / "hall.v1"))
    handle.cancel()
    assert code == 0
    assert [Path(f).name for f in facts["files"]] == ["hall.v1.yaml", "hall.v1.pgm", "hall.v1.png"]
    loaded = GridMap.load(tmp_path / "hall.v1.yaml")
    assert (loaded.cells == sim.world.site.grid.cells).all()
    assert loaded.origin == sim.world.site.grid.origin
    pixels = read_png((tmp_path / "hall.v1.png").read_bytes())
    for color in ((220, 30, 30), (240, 130, 0), (0, 0, 0), (254, 254, 254)):  # robot, scan, wall, floor
        assert has(pixels, color)
    code, facts = document("map", "save", str(tmp_path / "bare.yaml"), "--no-png")
    assert [Path(f).name for f in facts["files"]] == ["bare.yaml", "bare.pgm"]


def test_the_path_of_a_driving_robot_is_in_the_picture(tmp_path):
    """The path is published when it is planned: a new goal now and then, in real time, so that it drives."""
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        chassis.go_to(8.0, -2.0)
        chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.1)
        arguments = ("--listen", "10", "--master", sim.master_uri)
        process = woosh_process("map", "save", str(tmp_path / "p"), *arguments)
        until_it_ends(process, lambda turn: turn % 5 or chassis.go_to(8.0, -2.0 + 0.1 * (turn % 7)))
    assert process.returncode == 0
    assert has(read_png((tmp_path / "p.png").read_bytes()), (30, 90, 220))


def test_map_show_and_set(sim, woosh, document, tmp_path):
    code, facts = document("map", "show")
    assert (code, facts["width"], facts["height"]) == (0, 240, 160)
    smaller = GridMap(np.zeros((100, 100), np.int8), 0.1, Pose2D(-5.0, -5.0))
    smaller.save(tmp_path / "small.yaml")
    assert woosh("map", "set", str(tmp_path / "small.yaml"), "--pose", "1", "1", "90")[0] == 0
    code, facts = document("map", "show")
    assert (facts["width"], facts["resolution"]) == (100, 0.1)
    (tmp_path / "bad.yaml").write_text("image: x.pgm\n")
    assert woosh("map", "set", str(tmp_path / "bad.yaml"))[0] == 2


def test_plan(sim, woosh, document, tmp_path):
    code, facts = document("plan", "6", "0.5", "0", "--png", str(tmp_path / "plan.png"))
    assert code == 0
    assert facts["path"][-1]["x"] == pytest.approx(6.0, abs=0.2)
    assert facts["length"] >= 6.0
    assert has(read_png((tmp_path / "plan.png").read_bytes()), (30, 90, 220))
    assert "points" in woosh("plan", "1", "0", "0", "--start", "0", "1", "0", "--tolerance", "0.1")[1]
    code, facts = document("plan", "100", "100", "0")
    assert (code, facts["path"]) == (1, [])
    assert woosh("plan", "1", "0", "0", "--tolerance", "99")[0] == 2
    assert sim.pose == Pose2D(0.0, 0.0, 0.0)


def test_localization(sim, woosh, document):
    code, facts = document("localization", "show")
    assert code == 0
    assert facts["deviation"][0] > 0.0
    assert woosh("localization", "pose", "0.1", "-0.2", "-15", "--deviation", "0.3")[0] == 0
    assert woosh("localization", "pose", "0", "0", "0", "--yaw-deviation", "0")[0] == 2
    assert woosh("localization", "stop")[0] == 0
    assert woosh("localization", "start")[0] == 0


def test_mode(sim, woosh, document):
    words = ("--direction", "forward", "--passage", "3", "--capacity", "2", "--permitted")
    assert document("mode", "wait-then-avoid", "--waiting-timeout", "4", "--max-speed", "0.5", *words)[0] == 0
    with sim.lock:
        assert sim.world.navigation.mode is NavigationMode.WAIT_THEN_AVOID
        assert sim.world.navigation.waiting_timeout == 4.0
    code, _, err = woosh("mode", "wait-then-avoid")
    assert code == 2
    assert "waiting_timeout" in err


def test_costmap(sim, woosh):
    assert woosh("costmap", "off")[0] == 0
    assert sim.world.costmaps_enabled is False
    assert woosh("costmap", "on")[0] == 0
    assert sim.world.costmaps_enabled is True
    assert woosh("costmap", "clear")[0] == 0


def test_footprint(woosh, document):
    code, facts = document("footprint", "--rectangle", "1.0", "0.6", "--padding", "0.1")
    assert code == 0
    assert facts["points"][0] == [pytest.approx(0.6), pytest.approx(0.4)]
    assert document("footprint", "--circle", "0.4", "--local")[1]["global"] is False
    assert (
        document("footprint", "--points", "-0.4,0.3 -0.4,-0.3 0.4,-0.3 0.4,0.3", "--global")[1]["local"]
        is False
    )


def test_led(sim, woosh, document):
    assert document("led", "--list")[1]["idle"] == int(LedState.IDLE)
    code, facts = document("led", "warning", "--color", "#ff8000", "--module", "2", "--urgency", "--abnormal")
    assert (code, facts["color"]) == (0, 0xFF8000)
    assert woosh("led", "idle", "--strip", "both")[0] == 0
    assert woosh("led", "idle", "--module", "9")[0] == 2


def test_say(woosh, document):
    assert document("say", "mind", "your", "feet") == (0, {"said": "mind your feet"})


def test_marks_are_kept_and_used(sim, woosh, document, private_config):
    assert "no marks" in woosh("marks", "list")[1]
    assert woosh("marks", "add", "A1", "--here", "--note", "shelf")[0] == 0
    assert woosh("marks", "add", "X2", "--pose", "1", "2", "90")[0] == 0
    assert woosh("marks", "add", "X3")[0] == 0
    code, facts = document("marks", "list")
    assert [m["name"] for m in facts] == ["A1", "X2", "X3"]
    assert facts[1]["pose"]["yaw"] == pytest.approx(math.pi / 2, abs=1e-3)
    assert MarkFile(private_config / "marks.json").names == ["A1", "X2", "X3"]
    assert woosh("marks", "remove", "X3")[0] == 0
    code, _, err = woosh("marks", "remove", "X22")
    assert code == 1
    assert "near names: X2" in err


def test_doctor_and_status_and_stop_as_json(woosh, document):
    assert document("status", "--wait", "2")[1]["ready"] is True
    assert document("stop")[1]["standing"] is True
    assert "findings" in document("doctor", "--listen", "1")[1]


def test_shell_runs_code(sim, woosh, capsys):
    assert woosh("shell", "-c", "print(chassis.battery.wait().percent, Pose2D(1, 2).x)")[1].split() == [
        "87",
        "1",
    ]
    assert woosh("shell", "-c", "raise SystemExit(7)")[0] == 7
    code, _, err = woosh("shell", "-c", "1 / 0")
    assert code == 1
    assert "ZeroDivisionError" in err


def test_leaving_the_shell_ends_what_it_started(sim, woosh):
    assert woosh("shell", "-c", "chassis.go_to_mark('B1')")[0] == 0
    assert sim.world.tasks.state is TaskState.CANCELLED


# -- all of them ---------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="sends a POSIX signal")
@pytest.mark.parametrize(
    "words",
    [["watch", "--lines"], ["faults", "--listen", "60"], ["imu", "-n", "100000"], ["sim", "--port", "0"]],
)
def test_ctrl_c_is_clean_in_what_runs_long(sim, words):
    process = woosh_process(*words, *([] if words[0] == "sim" else ["--master", sim.master_uri]))
    if words[0] == "faults":
        assert process.stderr is not None
        assert "listening" in process.stderr.readline()
    else:
        assert process.stdout is not None
        process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "interrupted" in err


TESTED_ELSEWHERE = {"demo", "sim", "drive", "completion", "learn", "record"}


def test_no_verb_is_left_out():
    """Each command stands in this file, or where the note says."""
    text = Path(__file__).read_text("utf-8")
    missing = [name for name in COMMANDS if name not in TESTED_ELSEWHERE and f'"{name}"' not in text]
    assert missing == []
