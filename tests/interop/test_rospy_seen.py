"""Programs of the kinds that people have (teleop, drivers, planners, filters, bridges ...), by rospy and by us.

One master for all that real rospy runs, one for all that we run; each program has a namespace of its own. Some
run at a time, because most of their time is waiting.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support.rospy_pair import PROGRAMS, Outcome, run_program

ARGUMENTS = {
    "mux": ["plain", "out:=elsewhere", "_speed:=0.5", "--flag"],
    "options": [
        *["/dev/tty", "_rate:=20", "_list:=[1, two]", "_text:=word", "_yes:=true", "--frame-id", "x"],
    ],
}
CODES = {"options": 2, "shutdown_from_callback": 3}
NAMES = sorted(file.stem for file in (PROGRAMS / "seen").glob("*.py"))
AT_A_TIME = 3
BATCHES = [NAMES[i::4] for i in range(4)]


def lines(outcome: Outcome) -> tuple[object, ...]:
    """What must be equal; the order of warnings of several threads is chance, and so is how often somebody tries in vain."""
    refused = {line for line in outcome.err if "Could not process inbound connection" in line}
    return (
        outcome.code,
        outcome.out,
        sorted(refused) + sorted(line for line in outcome.err if line not in refused),
    )


@pytest.mark.parametrize("names", BATCHES, ids=[names[0] for names in BATCHES])
def test_programs_do_what_they_do_with_rospy(names: list[str], genpy_packages: Path) -> None:
    """Exit code and both streams of each; all that differ are told at once."""
    with Master() as theirs, Master() as ours, ThreadPoolExecutor(2 * AT_A_TIME) as pool:
        runs = {
            (name, real): pool.submit(
                run_program,
                f"seen/{name}.py",
                *ARGUMENTS.get(name, []),
                real=real,
                packages=[genpy_packages] if real else [],
                master_uri=(theirs if real else ours).uri,
                env={"ROS_NAMESPACE": f"/{name}"},
            )
            for name in names
            for real in (True, False)
        }
        found = {
            name: (lines(runs[name, True].result()), lines(runs[name, False].result())) for name in names
        }
    assert {name: pair[1] for name, pair in found.items()} == {name: pair[0] for name, pair in found.items()}
    assert {name: pair[0][0] for name, pair in found.items()} == {name: CODES.get(name, 0) for name in names}
