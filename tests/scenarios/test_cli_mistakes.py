"""What people type wrongly, and what `woosh` then says: one sentence with the next step, and nothing moves."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto import Master
from rosproto.cli import main as rosproto
from tests.support.extras import needs
from woosh_pure import SimulatedChassis
from woosh_pure.cli.entry import main

pytestmark = pytest.mark.usefixtures("private_config")
Captured = pytest.CaptureFixture[str]


def exit_code(line: str) -> object:
    """Of `woosh LINE`; the parser leaves in its own way."""
    try:
        return main(line.split())
    except SystemExit as left:
        return left.code


@pytest.mark.parametrize(
    ("line", "code", "text"),
    [
        ("goto", 2, "give a mark or --pose"),
        ("goto 1 2", 2, "for a pose write: woosh goto --pose 1 2 DEGREES"),
        (
            "--timeout 1 goto A1",
            2,
            "not understood: --timeout; an option of a command is written behind it: woosh goto",
        ),
        (
            "--sim --speed 0.2 goto A1",
            2,
            "an option of a command is written behind it: woosh goto ... --speed",
        ),
        ("--chasis 127.0.0.1 status", 2, "not understood: --chasis; did you mean --chassis?"),
        ("goto 1,0", 2, "for a pose write: woosh goto --pose 1 0 DEGREES"),
        ("goto 1,-0.5,90", 2, "for a pose write: woosh goto --pose 1 -0.5 90"),
        ("goto 1 2 90", 2, "for a pose write: woosh goto --pose 1 2 90"),
        ("goto 会议 室", 2, "a mark is one word; quote it: woosh goto '会议 室'"),
        ("led", 2, "give a state (see --list) or --color"),
        ("led --color 12", 2, "expected six hexadecimal digits"),
        ("goto", 2, "your list has no marks yet: `woosh marks add NAME`"),
        ("--sim goto", 2, "give a mark or --pose X Y DEGREES; marks: A1, A2, B1, B2, C1, P1, W1"),
        ("--sim task pick", 2, "give a mark or --pose X Y DEGREES; marks: A1, A2"),
        ("--sim charge", 2, "give the mark of a charger; marks: A1, A2"),
        ("plan A9", 2, "A9: give X Y DEGREES, or a mark whose pose is known here; your list has no marks"),
        ("plan 1 2", 2, "1: give X Y DEGREES, or a mark"),
        ("plan inf 0 0", 2, "'inf' is not a plain decimal number"),
        (f"plan {400 * '9'} 0 0", 2, "must be at most 1000000000"),
        ("--sim plan A9", 2, "known here; did you mean A2 or A1?; marks: A1, A2"),
        ("forward 0.1", 2, "unknown command 'forward'; did you mean `woosh move METRES`?"),
        ("turn 10", 2, "did you mean `woosh rotate DEGREES`?"),
        ("right 10", 2, "did you mean `woosh rotate -DEGREES`?"),
        ("state", 2, "unknown command 'state'; did you mean `woosh status`?"),
        ("go A1", 2, "did you mean `woosh goto MARK`?"),
        ("move 0", 2, "the way is 0"),
        ("rotate -0", 2, "the way is 0"),
        ("charge C1 --no", 2, "not understood: --no"),  # and not --no-learned
        ("move 0.5 --no-av", 2, "not understood: --no-av; did you mean --no-avoid"),
        ("stop --end", 2, "not understood: --end"),
        ("led orang", 2, "did you mean orange?"),
        ("faults 7 --code 8", 2, "give one of: a code, a text, --code, --find"),
        ("costmap maybe", 2, "'maybe' is not a valid setting; one of: on, off, clear"),
        ("--sim --chassis 127.0.0.1 stop", 2, "contradict each other"),
        ("--chassis= status", 2, "--chassis is empty"),
        ("--master= stop", 2, "--master is empty"),
        ("--chassis 127.0.0.1 --host= status", 2, "--host is empty"),
        ("sim --port 0 --bind 203.0.113.7", 1, "no such address; give one of its own with --bind"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(line: str, code: int, text: str, capsys: Captured) -> None:
    """Without asking any chassis: also with $ROS_MASTER_URI set, an empty address never means another one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_MASTER_URI", "http://127.0.0.1:1")
        assert exit_code(line) == code
    assert text in capsys.readouterr().err


@pytest.fixture(scope="module")
def empty() -> Iterator[str]:
    """URI of a master without a chassis."""
    with Master() as master:
        yield master.uri


def test_a_master_without_a_chassis_is_not_ready(empty: str, capsys: Captured) -> None:
    """`woosh ready && woosh goto A1` must not go on: that nothing speaks against it is no yes there."""
    assert main(["--master", empty, "--json", "ready", "--listen", "0.1", "--wait", "0.2"]) == 3
    said = json.loads(capsys.readouterr().out)
    assert not said["ready"]
    assert [reason["key"] for reason in said["reasons"]] == ["no_chassis"]
    assert main(["--master", empty, "status", "--wait", "0.1"]) == 1
    assert f"NO: nobody publishes /robot_status at {empty}" in capsys.readouterr().out
    assert main(["--master", empty, "faults", "--listen", "0.1"]) == 1
    assert f"faults: nobody publishes /robot_status at {empty}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("map save /tmp/x", "service /aic_map_server/get_map: a node of the chassis is down"),
        ("costmap clear", "service /move_base/clear_costmaps: a node of the chassis is down"),
    ],
)
def test_what_a_chassis_lacks_is_said_without_our_api(
    empty: str, line: str, text: str, capsys: Captured
) -> None:
    """Who types commands cannot call `wait()`."""
    assert main(["--master", empty, *line.split()]) == 1
    said = capsys.readouterr().err
    assert text in said
    assert "wait()" not in said


def test_a_refusal_does_not_talk_of_stopping(capsys: Captured) -> None:
    """Nothing began; too long a step and an unknown mark say what to do instead."""
    with SimulatedChassis(speed=8) as sim:
        assert main(["--master", sim.master_uri, "goto", "标记一"]) == 3
        said = capsys.readouterr()
        assert "标记一: refused by the chassis: this mark is not known" in said.err
        assert said.out == ""
        assert main(["--master", sim.master_uri, "move", "500"]) == 2
        assert "for longer distances: woosh goto --pose X Y DEGREES" in capsys.readouterr().err


def test_a_chassis_that_is_registered_and_silent_is_not_ready(sim, woosh):
    """Its computer is up and its nodes hang: that nothing speaks against moving is no answer then."""
    sim.fall_silent(60.0)
    code, out, _ = woosh("ready", "--listen", "0.2")
    assert code == 3
    assert out == "NOT READY: nothing is received from the chassis: is it running? try `woosh doctor`\n"


def test_the_marks_of_the_list_are_named(woosh):
    """`woosh goto` alone is a question, and no order."""
    assert woosh("marks", "add", "仓库", "--no-pose")[0] == 0
    code, _, err = woosh("goto")
    marks = "A1, A2, B1, B2, C1, P1, W1, 仓库"  # the simulator's, too
    assert (code, err) == (2, f"woosh: goto: give a mark or --pose X Y DEGREES; marks: {marks}\n")
    code, _, err = woosh("plan", "仓库")
    assert (code, "whose pose is known here; marks: A1, " in err) == (2, True)


@pytest.mark.parametrize(
    ("words", "near"),
    [
        (("goto", "a1"), "A1"),
        (("goto", "B9"), "B2 or B1"),
        (("task", "pick", "b1"), "B1"),
        (("charge", "c2"), "C1"),
    ],
)
def test_a_mark_that_is_not_known_is_answered_by_near_ones_and_the_list(woosh, words, near):
    """The simulator tells its marks; nothing is driven to by a guess."""
    code, out, err = woosh(*words)
    assert (code, out) == (3, "")
    assert f"this mark is not known (robot state: idle); did you mean {near}" in err
    assert "marks: A1, A2, B1, B2, C1, P1, W1" in err


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("goto 1m 2m", "for a pose write: woosh goto --pose 1m 2m DEGREES"),
        ("goto 1 2 90度", "for a pose write: woosh goto --pose 1 2 90度"),
        ("goto A1 B1", "a mark is one word; quote it: woosh goto 'A1 B1'"),
        ("goto --pose 0 0 400", "'400': must be from -360 to 360"),
        ("rotate 3601", "3601° is more than the 3600° (ten turns) that one step may have"),
        ("led red --module 9", "module 9: expected 0 for all, or 1 to 8"),
        ("led 红色", "did you mean red?"),
        ("move 500", "for longer distances: woosh goto --pose X Y DEGREES"),
    ],
)
def test_numbers_and_words_that_are_refused_say_what_to_write(woosh, line, text):
    code, out, err = woosh(*line.split())
    assert (code, out) == (2, "")
    assert text in err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("localization", "pose", "0", "0", "400"), "argument DEGREES: '400': must be from -360 to 360"),
        (("sim", "--robots", "0"), "argument --robots: '0' is not a whole number from 1 to 100"),
        (("--lang", "cn", "status"), "'cn' 不是有效的"),
    ],
)
def test_options_that_are_refused_say_what_is_allowed(
    capsys: Captured, words: tuple[str, ...], text: str
) -> None:
    """Also in the language that was meant by a wrong --lang."""
    with pytest.raises(SystemExit):
        main([*words])
    assert text in capsys.readouterr().err


def test_a_mark_of_the_users_list_is_near_too(woosh):
    assert woosh("marks", "add", "kitchen", "--pose", "1", "0", "0")[0] == 0
    assert "did you mean kitchen?" in woosh("goto", "kitchn")[2]
    assert "did you mean kitchen?" in woosh("plan", "kitchn")[2]


def test_what_is_no_status_code_is_explained(woosh):
    """A task state is not a fault, and none of its words is \"unknown\"."""
    code, out, _ = woosh("faults", "7")
    assert code == 0
    assert out == (
        "7 is not a status code (12 digits); in /robot_status it is task_state completed, robot_state following\n"
    )
    assert "emergency" in woosh("faults", "110201000013")[1]
    assert "110201000013" in woosh("faults", "emergency")[1]


def test_run_without_a_program_says_how(capsys: Captured) -> None:
    with pytest.raises(SystemExit) as left:
        rosproto(["run"])
    assert left.value.code == 2
    said = "the following arguments are required: program; for example: rosproto run program.py"
    assert capsys.readouterr().err == f"rosproto run: {said}\n"


def test_a_verb_without_its_command_is_named(capsys: Captured) -> None:
    with pytest.raises(SystemExit):
        rosproto(["echo", "/odom"])
    assert "did you mean `rosproto topic echo`?" in capsys.readouterr().err


def test_a_bad_token_file_is_told_before_any_robot_is_announced(capsys: Captured, tmp_path: Path) -> None:
    needs("web")
    line = "sim --robots 2 --port 0 --page-port 0 --token-file"
    code = main([*line.split(), str(tmp_path / "none.txt")])
    said = capsys.readouterr()
    assert (code, said.out) == (1, "")
    assert "none.txt" in said.err
