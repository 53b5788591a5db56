"""`woosh map`, `plan`, `mode`, `costmap`, `footprint`, lights, voice, marks and the shell on a simulated chassis."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.extras import needs
from tests.support.png import read_png
from tests.support.woosh_command import has, woosh_process
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.enums import LedState, NavigationMode, TaskState
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import MarkFile, UserMark

pytestmark = pytest.mark.usefixtures("private_config")


def test_map_save_writes_what_map_server_reads_and_a_picture(sim, chassis, woosh, document, tmp_path):
    needs("cli")
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
    """Also for who comes when it drives already; in real time, so that it still does then."""
    needs("cli")
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis:
        chassis.go_to(8.0, -2.0)
        chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.1)
        process = woosh_process("map", "save", str(tmp_path / "p"), "--master", sim.master_uri)
        process.communicate(timeout=30)
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


def test_a_plan_is_drawn(sim, document, tmp_path):
    needs("cli")
    code, _ = document("plan", "6", "0.5", "0", "--png", str(tmp_path / "plan.png"))
    assert code == 0
    assert has(read_png((tmp_path / "plan.png").read_bytes()), (30, 90, 220))


def test_plan(sim, woosh, document):
    code, facts = document("plan", "6", "0.5", "0")
    assert code == 0
    assert facts["path"][-1]["x"] == pytest.approx(6.0, abs=0.2)
    assert facts["length"] >= 6.0
    assert "points" in woosh("plan", "1", "0", "0", "--start", "0", "1", "0", "--tolerance", "0.1")[1]
    code, facts = document("plan", "100", "100", "0")
    assert (code, facts["path"]) == (1, [])
    assert woosh("plan", "1", "0", "0", "--tolerance", "99")[0] == 2
    assert sim.pose == Pose2D(0.0, 0.0, 0.0)


def test_localization(sim, woosh, document):
    code, facts = document("localization", "show")
    assert code == 0
    assert facts["deviation"][0] > 0.0
    assert woosh("localization", "pose", "0.1", "-0.2", "-15°", "--deviation", "0.3")[0] == 0
    assert woosh("localization", "pose", "0", "0", "0", "--yaw-deviation", "0")[0] == 2
    assert woosh("localization", "stop")[0] == 0
    assert woosh("localization", "start")[0] == 0


@pytest.mark.parametrize("lost", [False, True])
def test_a_position_counts_when_the_robot_reports_it(sim, woosh, document, lost):
    """A hint far from where it stands is ignored by the localisation: that is exit code 1 and a sentence."""
    if lost:
        sim.lose_localization()
    code, out, _ = woosh("localization", "pose", "5", "2", "90", "--wait", "1")
    assert (code, "the robot has NOT taken it: it reports x 0.0" in out) == (1, True)
    assert document("localization", "pose", "5", "2", "90", "--wait", "0.5")[1]["ok"] is False
    code, out, _ = woosh("localization", "pose", "0", "0", "0", "--wait", "20")
    assert (code, "the robot has taken it: it reports x " in out) == (0, True)


def test_mode(sim, woosh, document):
    words = ("--direction", "forward", "--passage", "3", "--capacity", "2", "--permitted")
    assert document("mode", "wait-then-avoid", "--waiting-timeout", "4", "--max-speed", "0.5", *words)[0] == 0
    with sim.lock:
        assert sim.world.navigation.mode is NavigationMode.WAIT_THEN_AVOID
        assert sim.world.navigation.waiting_timeout == 4.0
    code, _, err = woosh("mode", "wait-then-avoid")
    assert code == 2
    assert "wait-then-avoid needs --waiting-timeout, in seconds" in err


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


def test_marks_of_the_simulated_hall_say_which_is_a_charger(capsys: pytest.CaptureFixture[str]) -> None:
    """As `woosh --sim web` shows them; the user's own list is not read."""
    assert main(["--sim", "marks", "list", "--json"]) == 0
    marks = {mark["name"]: mark["charger"] for mark in json.loads(capsys.readouterr().out)}
    assert marks["C1"] is True
    assert marks["A1"] is False


def test_marks_are_kept_and_used(sim, woosh, document, private_config):
    hall = [*sim.world.site.marks]
    assert [m["name"] for m in document("marks", "list")[1]] == sorted(hall)
    assert woosh("marks", "add", "A1", "--here", "--note", "shelf")[0] == 0
    assert woosh("marks", "add", "X2", "--pose", "1", "2", "90")[0] == 0
    assert woosh("marks", "add", "X3", "--no-pose")[0] == 0
    code, facts = document("marks", "list")
    assert [m["name"] for m in facts] == sorted({*hall, "A1", "X2", "X3"})
    facts = {m["name"]: m for m in facts}
    assert facts["A1"]["note"] == "shelf"  # ours goes before the simulator's
    assert facts["X2"]["pose"]["yaw"] == pytest.approx(math.pi / 2, abs=1e-3)
    assert MarkFile(private_config / "marks.json").names == ["A1", "X2", "X3"]
    assert woosh("marks", "remove", "X3")[0] == 0
    code, _, err = woosh("marks", "remove", "X22")
    assert code == 1
    assert "did you mean X2?" in err


def test_a_list_without_marks_says_so(private_config, capsys):
    assert main(["--master", "http://127.0.0.1:1", "marks", "list"]) == 0
    assert "no marks in" in capsys.readouterr().out


def test_a_mark_is_kept_where_the_robot_is(sim, woosh, document, private_config):
    """Without an option; what it was before is told."""
    with sim.lock:
        sim.world.body.pose = Pose2D(1.0, 0.5, 0.0)
        assert sim.world.initial_pose(Pose2D(1.0, 0.5, 0.0))
    code, out, _ = woosh("marks", "add", "here")
    assert (code, "x 1.0" in out) == (0, True)
    assert woosh("goto", "--pose", "0", "0", "0")[0] == 0
    code, out, _ = woosh("marks", "add", "here")
    assert re.search(r"it was x 1\.0.* before", out)
    assert document("plan", "here")[1]["ok"] is True
    assert MarkFile(private_config / "marks.json").names == ["here"]


@pytest.mark.parametrize("words", [("--pose", "0.5", "0", "0"), ("--place", "--pose", "0.5", "0", "0")])
def test_goto_drives_to_the_pose_of_a_place(sim, woosh, private_config, words):
    """As the page saves it: the chassis has no mark of this name."""
    code, _, err = woosh("marks", "add", "mine", "--place", "--no-pose")
    assert (code, "it needs a pose" in err) == (2, True)
    assert woosh("marks", "add", "mine", *words)[0] == 0
    assert list(MarkFile(private_config / "marks.json")) == [
        UserMark("mine", Pose2D(0.5, 0.0), on_chassis=False)
    ]
    code, out, _ = woosh("goto", "mine")
    assert (code, "going to mark mine" in out) == (0, True)
    with sim.lock:
        assert sim.world.body.pose.distance_to(Pose2D(0.5, 0.0)) < 0.2


def test_a_place_is_kept_where_the_robot_is_and_found_again(sim, woosh, private_config):
    """`marks add desk`, then `goto desk` from elsewhere."""
    assert woosh("goto", "--pose", "0.6", "0.2", "0")[0] == 0
    assert woosh("marks", "add", "desk")[0] == 0
    assert woosh("goto", "--pose", "0", "0", "0")[0] == 0
    assert woosh("goto", "desk")[0] == 0
    with sim.lock:
        assert sim.world.body.pose.distance_to(Pose2D(0.6, 0.2)) < 0.2


def test_a_mark_of_the_chassis_is_asked_for_by_name(sim, woosh, private_config):
    """`--on-chassis`, and `--no-pose`; a pose that is added later makes a place of it, and this is said."""
    assert woosh("marks", "add", "B1", "--on-chassis", "--pose", "9", "9", "0")[0] == 0
    assert woosh("goto", "B1")[0] == 0  # the pose is outside the hall
    code, out, _ = woosh("marks", "add", "B1", "--pose", "0.5", "0", "0")
    assert (code, "`woosh goto B1` drives to this pose now" in out) == (0, True)
    assert woosh("marks", "add", "B1", "--no-pose")[0] == 0
    assert list(MarkFile(private_config / "marks.json")) == [UserMark("B1")]


def test_marks_of_a_simulated_robot_are_kept_in_no_list_of_a_real_one(capsys, private_config, tmp_path):
    assert main(["--sim", "marks", "add", "desk"]) == 2
    assert "your list is for real robots" in capsys.readouterr().err
    assert not (private_config / "marks.json").exists()
    kept = tmp_path / "sim.json"
    assert main(["--sim", "marks", "--file", str(kept), "add", "desk"]) == 0
    assert MarkFile(kept).names == ["desk"]
    capsys.readouterr()
    assert main(["--sim", "marks", "list", "--json"]) == 0
    assert {"A1", "B1"} <= {mark["name"] for mark in json.loads(capsys.readouterr().out)}


def test_with_sim_goto_takes_no_place_of_the_list(capsys, private_config):
    """The list is of another map."""
    assert main(["--master", "http://127.0.0.1:1", "marks", "add", "B1", "--pose", "90", "90", "0"]) == 0
    capsys.readouterr()
    assert main(["--sim", "--sim-speed", "8", "goto", "B1"]) == 0
    assert "x 90" not in capsys.readouterr().out


def test_no_mark_is_kept_of_a_robot_that_is_lost(capsys, private_config):
    with SimulatedChassis(full_graph=False) as lost:
        lost.lose_localization()
        assert main(["--master", lost.master_uri, "marks", "add", "lost"]) == 1
    assert "does not know where it is" in capsys.readouterr().err
    assert not (private_config / "marks.json").exists()


def test_without_a_robot_a_mark_is_kept_by_other_options(capsys, private_config):
    assert main(["--master", "http://127.0.0.1:1", "marks", "add", "A1"]) == 4
    assert "`--no-pose` keeps a mark without asking" in capsys.readouterr().out
    assert not (private_config / "marks.json").exists()


def test_doctor_and_status_and_stop_as_json(woosh, document):
    assert document("status", "--wait", "20")[1]["ready"] is None  # it has not told its state
    assert document("stop")[1]["standing"] is True
    assert "findings" in document("doctor", "--listen", "1")[1]


def test_shell_runs_code(sim, woosh, capsys):
    assert woosh("shell", "-c", "print(chassis.battery.wait().percent, Pose2D(1, 2).x)")[1].split() == [
        "87",
        "1.0",
    ]
    assert woosh("shell", "-c", "raise SystemExit(7)")[0] == 7
    code, _, err = woosh("shell", "-c", "1 / 0")
    assert code == 1
    assert "ZeroDivisionError" in err


def test_leaving_the_shell_ends_what_it_started(sim, real_time, woosh):
    assert woosh("shell", "-c", "chassis.go_to_mark('B1')")[0] == 0
    assert sim.world.tasks.state is TaskState.CANCELLED
