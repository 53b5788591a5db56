"""The verbs of `woosh` that read and move, against a simulated chassis: what they do, print, write, and their exit codes.

The rest of them: test_cli_navigation.py.
"""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.extras import needs
from tests.support.png import read_png
from tests.support.robot_api_peer import ApiPeer
from tests.support.woosh_command import has, until_it_ends, woosh_process
from woosh_pure.cli.commands import COMMANDS
from woosh_pure.enums import RobotMode, TaskState

pytestmark = [pytest.mark.whole, pytest.mark.usefixtures("private_config")]


# -- reading -------------------------------------------------------------------------------------------------


def test_ready_says_that_it_is_not_known(document):
    """The state is sent on change only, and nothing changes; a yes is in test_not_known.py."""
    code, facts = document("ready")
    assert (code, facts["ready"], facts["answer"]) == (5, None, "not known")


def test_ready_says_no_and_why(sim):
    """The mode is told on change only, so it changes until it is heard."""
    process = woosh_process("ready", "--master", sim.master_uri, "--listen", "20", "--json")
    modes = (RobotMode.MANUAL, RobotMode.MAINTENANCE)
    facts = json.loads(until_it_ends(process, lambda turn: sim.set_mode(modes[turn % 2])))
    assert process.returncode == 3
    assert facts["ready"] is False
    assert "manual_mode" in [reason["key"] for reason in facts["reasons"]]


def test_ready_waits(sim):
    """The last mode stays long enough to be heard as steady."""
    process = woosh_process("ready", "--master", sim.master_uri, "--wait", "30")
    modes = (RobotMode.MANUAL, *[RobotMode.AUTOMATIC] * 30)
    out = until_it_ends(process, lambda turn: sim.set_mode(modes[turn % 31]))
    assert process.returncode == 0
    assert out.startswith("ready: ")


def test_battery_with_a_threshold(woosh, document):
    code, facts = document("battery")
    assert code == 0
    assert facts["percent"] == 87
    assert facts["charge_status"] == "NOT_CHARGING"
    assert woosh("battery", "--below", "90")[0] == 1
    assert woosh("battery", "--below", "50")[0] == 0


def test_faults_are_told_and_codes_explained(sim, woosh, document, until):
    code, out, _ = woosh("faults", "--listen", "0.3")
    assert code == 5
    assert "not known: no code was heard" in out
    code, facts = document("faults", "--code", "110201000013")
    assert facts[0]["level"] == "SEVERE"
    assert woosh("faults", "--find", "emergency")[0] == 0
    assert woosh("faults", "--find", "no such words")[0] == 1
    assert "急停" in woosh("faults", "--code", "110201000013", "--chinese")[1]


def test_an_active_fault_is_exit_code_1(sim):
    process = woosh_process("faults", "--master", sim.master_uri, "--listen", "3")
    out = until_it_ends(process, lambda _: sim.report(110201000013))  # it counts from when it listens
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


def test_scan_in_words_and_json(sim, woosh, document):
    assert "ahead" in woosh("scan")[1]
    code, facts = document("scan")
    assert code == 0
    assert len(facts["ranges"]) == 360
    assert facts["nearest"]["ahead"] > 0.5


def test_scan_in_pictures(sim, woosh, document, tmp_path):
    needs("cli")
    code, _ = document("scan", "--png", str(tmp_path / "scan.png"))
    assert code == 0
    pixels = read_png((tmp_path / "scan.png").read_bytes())
    assert has(pixels, (240, 130, 0))
    assert has(pixels, (220, 30, 30))
    assert woosh("scan", "--map", "--png", str(tmp_path / "map.png"))[0] == 0
    assert read_png((tmp_path / "map.png").read_bytes()).shape == (320 + 56, 480 + 56, 3), (
        "with the margins of its grid"
    )


def test_camera_in_colour_and_depth(woosh, document, tmp_path):
    code, facts = document("camera", "--png", str(tmp_path / "color.png"))
    assert (code, facts["encoding"]) == (0, "rgb8")
    assert read_png((tmp_path / "color.png").read_bytes()).shape == (facts["height"], facts["width"], 3)
    code, facts = document("camera", "--depth", "--millimetres", "--png", str(tmp_path / "mm.png"))
    depth = read_png((tmp_path / "mm.png").read_bytes())
    assert depth.dtype == ">u2"
    assert depth[depth > 0].min() == pytest.approx(facts["nearest"] * 1000, abs=60)
    assert facts["farthest"] > facts["nearest"]
    assert woosh("camera", "--depth", "--png", str(tmp_path / "depth.png"))[0] == 0
    shown = read_png((tmp_path / "depth.png").read_bytes())
    assert (shown.dtype, shown.max()) == (np.uint8, 255), "scaled to its range: a person sees something"


@pytest.mark.parametrize(
    "words", [("camera", "-o"), ("camera", "--depth", "--png"), ("scan", "--png"), ("plan", "A1", "-o")]
)
def test_a_picture_that_is_no_png_is_refused(woosh, tmp_path, words):
    """The name would lie about the bytes."""
    code, _, err = woosh(*words, str(tmp_path / "a.jpg"))
    assert code == 2
    assert "pictures are written as PNG; give a name that ends in .png" in err
    assert list(tmp_path.glob("a.*")) == []


def test_a_picture_is_saved_without_being_told_where(woosh, tmp_path, monkeypatch):
    """Two in one second make two files; --no-file makes none."""
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        code, out, _ = woosh("camera")
        assert code == 0
        assert "rgb8" in out
        assert "wrote camera-" in out
    assert len(list(tmp_path.glob("camera-*.png"))) == 2
    assert woosh("camera", "--depth", "--no-file")[0] == 0
    assert list(tmp_path.glob("depth*")) == []
    assert woosh("camera", "--millimetres")[0] == 2


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
    seconds = 0.6
    while "yaw" not in (said := woosh("watch", "--for", str(seconds), "--rate", "5", "--lines"))[1]:
        assert (said[0], seconds < 30.0) == (0, True), said
        seconds *= 3.0  # a busy computer hears its first pose late
    code, out, _ = woosh("watch", "--for", str(seconds + 0.2), "--rate", "5", "--json", "--no-map")
    assert code == 0
    documents = [json.loads(line) for line in out.splitlines()]
    assert len(documents) >= 2
    assert documents[-1]["pose"]["x"] == pytest.approx(0.0, abs=0.01)


# -- moving --------------------------------------------------------------------------------------------------


@pytest.mark.slow
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


def test_a_running_task_is_paused_resumed_and_cancelled(sim, real_time, chassis, woosh, document, until):
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


def test_a_task_that_fails_and_one_that_is_late(sim, real_time, woosh):
    sim.fail_task("gripper jammed")
    code, _, err = woosh("task", "pick", "A1")
    assert code == 1
    assert "gripper jammed" in err
    code, _, err = woosh("task", "pick", "B1", "--timeout", "0.3")
    assert code == 1
    assert "timed out" in err
    assert sim.world.body.velocity.is_standing()


def test_goto_move_rotate_as_json(sim, document):
    _, arrived = document("goto", "--pose", "1", "0", "90")
    assert arrived["outcome"] == "arrived"
    assert sim.world.body.pose.x == pytest.approx(1.0, abs=0.1)
    assert arrived["pose"]["x"] == pytest.approx(
        1.0, abs=0.5
    )  # the last received; the robot is eight times as fast
    assert document("move", "0.2", "--speed", "0.5")[1]["outcome"] == "arrived"
    assert document("rotate", "-45", "--speed", "60")[1]["ok"] is True


def test_a_failed_goal_is_json_too(sim, document):
    code, facts = document("goto", "Z9")
    assert code == 3
    assert facts["ok"] is False


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


TESTED_ELSEWHERE = {
    *(
        "demo",
        "sim",
        "drive",
        "completion",
        "learn",
        "mcp",
        "mission",
        "record",
        "run",
        "selftest",
        "web",
        "foxglove",
        "robot-api",
        "vda5050",
    )
}


def test_api_asks_a_question_and_shows_the_answer(document):
    with ApiPeer() as peer:
        code, facts = document("api", "Battery", "--api-address", peer.address)
    assert (code, peer.requests[-1]) == (0, "Battery")
    assert facts["power"] == 83


def test_no_verb_is_left_out():
    """Each command stands in one of these files, or where the note says."""
    here = Path(__file__).parent
    files = ("test_cli_verbs.py", "test_cli_choosing.py", "test_cli_navigation.py")
    text = "".join((here / name).read_text("utf-8") for name in files)
    missing = [name for name in COMMANDS if name not in TESTED_ELSEWHERE and f'"{name}"' not in text]
    assert missing == []


@pytest.mark.slow
def test_a_drive_tells_the_way_left_line_by_line(real_time, woosh):
    """Where no terminal is, a line every two seconds; two lines for a whole drive told nothing."""
    code, out, err = woosh("goto", "--pose", "3", "1", "90")
    assert code == 0, err
    lines = [line for line in out.splitlines() if " m left" in line]
    assert len(lines) >= 2, out
    left = [float(line.split(" m left")[0].split()[-1]) for line in lines]
    assert left == sorted(left, reverse=True)
    assert any("about" in line for line in lines)
