"""`woosh run PROGRAM`: what a person at a terminal is told when the program fails, or only stands still."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.waiting import until
from tests.support.woosh_command import woosh_process
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.outcome import ENDED_EARLY
from woosh_pure.stopping.active_motions import ActiveMotions

pytestmark = pytest.mark.usefixtures("private_config")
DRIVES = "from woosh_pure import Chassis\n\ndef go(c):\n    {}\n\nwith Chassis() as c:\n    go(c)\n"


def run(tmp_path: Path, code: str, *words: str, options: tuple[str, ...] = ("--sim",)) -> tuple[int, str]:
    """Exit code and stderr of a program."""
    program = tmp_path / "first.py"
    program.write_text(code)
    process = woosh_process("run", *options, str(program), *words)
    err = process.communicate(timeout=60)[1]
    return process.returncode, err


def test_an_error_shows_the_programs_own_frames_and_the_sentence(tmp_path: Path) -> None:
    """Up to twenty lines of the library stood above the sentence."""
    code, err = run(tmp_path, DRIVES.format('c.go_to_mark("a1").wait()'))
    assert code == 1
    files = [line for line in err.splitlines() if line.startswith("  File ")]
    assert len(files) == 2
    assert all("first.py" in line for line in files)
    assert "woosh_pure.errors.MotionRefused: drive to a1: refused by the chassis" in err.splitlines()[-1]


def test_causes_of_the_program_stay_and_debug_shows_all(tmp_path: Path) -> None:
    own = "try:\n    int('x')\nexcept ValueError as error:\n    raise RuntimeError('mine') from error\n"
    code, err = run(tmp_path, own, options=())
    assert (code, err.count("Traceback"), "direct cause" in err) == (1, 2, True)
    code, err = run(tmp_path, DRIVES.format('c.go_to_mark("a1").wait()'), options=("--sim", "--debug"))
    assert (code, "verbs.py" in err) == (1, True)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("speed = 1\nprint(sped)\n", "NameError: name 'sped' is not defined. Did you mean: 'speed'?"),
        ("import math\nmath.sqr(2)\n", "Did you mean: 'sqrt'?"),
        ("import time\ndef go():\n    tme.sleep(1)\ngo()\n", "Did you mean: 'time'?"),
        ("print('x'\n", "SyntaxError: '(' was never closed"),
    ],
)
def test_pythons_own_help_stays(tmp_path: Path, code: str, said: str) -> None:
    """Python 3.11 and earlier give it by their own printing of an error alone."""
    exit_code, err = run(tmp_path, code, options=())
    assert exit_code == 1
    assert said in err.splitlines()[-1]
    assert all("first.py" in line for line in err.splitlines() if line.startswith("  File "))


def test_an_error_that_is_its_own_cause_is_shown_once(tmp_path: Path) -> None:
    code = "a, b = ValueError('a'), KeyError('b')\na.__cause__, b.__cause__ = b, a\nraise a\n"
    assert run(tmp_path, code, options=())[1].splitlines()[-1] == "ValueError: a"


@pytest.mark.parametrize(
    "code", [DRIVES.format("c.forward(0.5)"), "from woosh_pure import Chassis\nChassis().left(90)\n"]
)
def test_a_program_that_only_stood_still_is_told_that_wait_may_be_missing(tmp_path: Path, code: str) -> None:
    exit_code, err = run(tmp_path, code)
    assert exit_code == 0
    assert err.count("`.wait()` may be missing") == 1


def test_a_motion_that_has_ended_before_the_closing_looks_is_told_as_ended_early(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Closing asks for its end first, and a quick robot has answered by then."""
    end_all = ActiveMotions.end_all

    def late(motions: ActiveMotions, why: str, seconds: float = 3.0) -> list[str]:
        until(lambda: not motions.goals)
        return end_all(motions, why, seconds)

    monkeypatch.setattr(ActiveMotions, "end_all", late)
    with caplog.at_level(logging.INFO, ENDED_EARLY), SimulatedChassis(full_graph=False) as sim:
        with Chassis(sim.master_uri) as chassis:
            chassis.forward(0.5)
        assert [record.name for record in caplog.records].count(ENDED_EARLY) == 1


def test_a_program_that_waited_or_failed_is_told_nothing_of_wait(tmp_path: Path) -> None:
    assert ".wait()" not in run(tmp_path, DRIVES.format("c.forward(0.1).wait()"))[1]
    assert "may be missing" not in run(tmp_path, DRIVES.format("c.forward(1); raise ValueError('mine')"))[1]


def test_an_option_behind_the_file_is_the_programs_and_is_told(tmp_path: Path) -> None:
    """As with `python FILE ARGUMENTS`; the program may take it."""
    code, err = run(
        tmp_path, "import sys; sys.exit(sys.argv[1:] != ['--sim', 'x'])", "--sim", "x", options=()
    )
    assert (code, "--sim was given to " in err, "woosh run --sim " in err) == (0, True, True)
    assert run(tmp_path, "", "_speed:=1", "--", options=()) == (0, "")


def test_an_import_of_another_name_is_answered(tmp_path: Path) -> None:
    code, err = run(tmp_path, "import woosh", options=())
    assert (code, "did you mean `from woosh_pure import Chassis`?" in err) == (1, True)


def test_a_missing_file_is_an_error_at_once(tmp_path: Path) -> None:
    process = woosh_process("run", "--sim", "--watch", str(tmp_path / "none.py"))
    assert "none.py: there is no such file" in process.communicate(timeout=60)[1]
    assert process.returncode == 2


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals to a process")
@pytest.mark.promise(
    "Ctrl-C or SIGTERM in a `woosh` command", "SIGQUIT (Ctrl-\\\\) or SIGHUP to a `woosh` command"
)
@pytest.mark.parametrize(
    ("name", "code"), [("SIGTERM", 143), ("SIGHUP", 143), ("SIGQUIT", 143), ("SIGINT", 130)]
)
def test_a_signal_ends_the_program_and_stops_its_motion(
    name: str, code: int, sim: SimulatedChassis, real_time: object, tmp_path: Path, until: Callable[..., None]
) -> None:
    """A closed window, too: the robot must not drive on."""
    program = tmp_path / "first.py"
    program.write_text("from woosh_pure import Chassis\n\nchassis = Chassis()\nchassis.forward(3).wait()\n")
    process = woosh_process("--master", sim.master_uri, "run", str(program))
    until(lambda: not sim.world.body.velocity.is_standing())
    process.send_signal(getattr(signal, name))
    err = process.communicate(timeout=60)[1]
    assert process.returncode in (code, -getattr(signal, name)), err
    assert sim.world.motion is None
    until(lambda: sim.world.body.velocity.is_standing())
    assert ("woosh: terminated" in err) == (code == 143)
