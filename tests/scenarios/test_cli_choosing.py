"""Which chassis a `woosh` command works on, and what it says when it is used wrongly."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosproto.cli import main as rosproto
from woosh_pure import Chassis
from woosh_pure.cli import main

pytestmark = pytest.mark.usefixtures("private_config")


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


def test_programs_and_rosproto_know_what_connect_remembers(sim, capsys, private_config, monkeypatch):
    """One rule: the argument, $ROS_MASTER_URI, the saved robot."""
    assert main(["connect", sim.master_uri, "--host", "127.0.0.1"]) == 0
    with Chassis() as chassis:
        assert chassis.master_uri == sim.master_uri
        assert chassis.node.host_given == "127.0.0.1"
    assert rosproto(["topic", "list"]) == 0
    assert "/robot_status" in capsys.readouterr().out
    assert Chassis("10.0.0.1").master_uri == "http://10.0.0.1:11311/"
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
    assert Chassis().master_uri.startswith("http://127.0.0.1:1")
    assert rosproto(["topic", "list"]) != 0
    assert rosproto(["topic", "list", "--master", sim.master_uri]) == 0


def test_without_a_robot_the_error_names_every_way_to_one(capsys):
    assert main(["battery"]) == 2
    said = capsys.readouterr().err
    assert all(way in said for way in ("ROS_MASTER_URI", "woosh connect 169.254.128.2", "woosh --sim"))


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
        ["task", "pick"],
        ["goto"],
        ["goto", "A1", "--pose", "1", "2", "3"],
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
        ["watch", "--rate", "1000"],
        ["plan"],
        ["plan", "1", "inf", "0"],
        ["task"],
        ["task", "carry", "A1"],
        ["map"],
        ["mode", "fast"],
        ["costmap", "maybe"],
        ["footprint"],
        ["footprint", "--circle", "-1"],
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
    assert code == 1
    assert err.removeprefix("connecting ...\n") == "bye\n"  # said where connecting takes long


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
