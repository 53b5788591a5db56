"""Every number of every command: a value out of range or malformed is wrong use, before anything is asked.

The parsers are asked, so no robot and no master is needed. What a parser cannot know is in the last table.
"""

from __future__ import annotations

import argparse
import contextlib
import io

import pytest

from tests.support.extras import needs
from tests.support.options import arguments_of, places, run
from tests.support.ports import unused_port
from tests.unit.cli.test_plain_numbers import NUMBERS

MALFORMED = ("", "x", "nan", "inf", "-inf", "1e1", "0x1", "9" * 400)

SIGNED = frozenset(
    {
        "--code",  # explained, or refused by the command: see the last table
        "--custom",
        "--module",
        "--pose",
        "--seed",
        "--undock",
        "degrees",
        "metres",
        "plan --start",
        "x",
        "y",
    }
)
"""Below 0 has a meaning (or a limit that is not 0)."""

FROM_ZERO = frozenset(
    {
        "--below",  # an empty battery
        "--buffsize",  # no limit, as in rosbag
        "--capacity",
        "--delay",
        "--duration",  # of a bag: none of it
        "--ends-with",  # a file of the system
        "--for",
        "--id",
        "--listen",
        "--max-speed",  # the configured one
        "--min-space",
        "--padding",
        "--http",  # a free port
        "--page-port",  # a free one
        "--passage",
        "--port",  # a free one
        "--rate-control-max-delay",
        "--robot-api",  # a free port
        "--seconds",  # of tf
        "--skip-empty",
        "--start",
        "--tolerance",
        "--type-number",
        "--wait",  # of what only looks
        "--waiting-timeout",
    }
)
"""0 has a meaning."""

ABOVE_ZERO = frozenset(
    {
        *(f"{verb} --wait" for verb in ("battery", "camera", "cloud", "imu", "show", "add", "scan")),
        "echo --seconds",
        "record --duration",
        "vda5050 --tolerance",
    }
)
"""Of these, no."""


def parsed(parser: argparse.ArgumentParser, action: argparse.Action, text: str) -> tuple[int, str]:
    """Give this text to one argument: the exit code and stderr."""
    several = [text, "0", "0"][: action.nargs] if isinstance(action.nargs, int) else [text]
    words = [f"{action.option_strings[-1]}={text}"] if action.option_strings else []
    if action.option_strings and len(several) > 1:
        words = [action.option_strings[-1], *several]
    if not action.option_strings:
        before = [one for one in arguments_of(parser) if not one.option_strings]
        words = [*("1" for _ in before[: before.index(action)]), text]
    err, code = io.StringIO(), 0
    with contextlib.redirect_stderr(err):
        try:
            parser.parse_args(words)
        except SystemExit as leaving:
            code = int(leaving.code or 0)
    return code, err.getvalue()


def is_refused(parser: argparse.ArgumentParser, action: argparse.Action, text: str) -> bool:
    """Whether the argument is refused: exit code 2, the usage, and one line that names it."""
    code, err = parsed(parser, action, text)
    names = ["/".join(action.option_strings), *action.option_strings, action.dest, str(action.metavar)]
    if text == "-inf" and not action.option_strings:
        return code == 2  # read as an option, which is unknown
    if not any(f"argument {name}: " in err for name in names):
        return False  # what is said is that another argument is missing
    assert code == 2
    assert "Traceback" not in err
    assert len(err.splitlines()) == 2, err
    return True


def known(path: str, action: argparse.Action, table: frozenset[str]) -> bool:
    """Whether a table has the argument, by itself or behind its verb."""
    name = action.option_strings[-1] if action.option_strings else action.dest
    return name in table or f"{path.split()[-1]} {name}" in table


def taken(
    *texts: str, but: frozenset[str] = frozenset(), except_of: frozenset[str] = frozenset()
) -> list[str]:
    """The arguments that take one of these texts, without those of `but`."""
    found = []
    parsers = {**dict(places("rosproto")), **dict(places("woosh"))}
    for path, action in NUMBERS:
        if action.option_strings[-1:] == ["--sim-speed"] and path != "woosh status":
            continue  # an option of every command
        if known(path, action, but) and not known(path, action, except_of):
            continue
        for text in texts:
            if not is_refused(parsers[path], action, text):
                name = action.option_strings[-1] if action.option_strings else action.dest
                found.append(f"{path} {name} {text[:30]!r}")
    return found


def test_what_is_not_a_number_is_refused_by_every_argument() -> None:
    assert taken(*MALFORMED) == []


def test_a_number_below_zero_is_refused_where_it_means_nothing() -> None:
    assert taken("-1", "-0.5", but=SIGNED) == []


def test_zero_is_refused_where_it_means_nothing() -> None:
    assert taken("0", but=SIGNED | FROM_ZERO, except_of=ABOVE_ZERO) == []


def test_a_number_that_no_queue_and_no_wait_takes_is_refused() -> None:
    """20 digits fit into 64 bits, in which a code, a seed and the number of a task are."""
    assert taken("9" * 20, but=frozenset({"--code", "--seed"})) == []


@pytest.mark.parametrize(
    "line",
    [
        "woosh move 10.1",
        "woosh move -10.1",
        "woosh rotate 3601",
        "woosh rotate -3601",
        "woosh faults --code -1",
        "woosh faults 99999999999999999999",
        "woosh battery --below 101",
        "woosh led red --module 9",
        "woosh led red --color 12345",
        "woosh watch --rate 31",
        "woosh task park A1 --custom 128",
        "woosh footprint --circle 2000",
        "woosh footprint --points 1,nan",
        "woosh footprint --points 1",
        "woosh sim --at x=estop",
        "woosh sim --at -1=estop",
        "woosh sim --at nan=estop",
        "woosh sim --mark A1=1,2",
        "woosh sim --mark A1=1,2,nan",
        "woosh sim --firmware 99.0",
        "woosh sim --port 65536",
        "woosh web --bind 0.0.0.0",
        "woosh web --port 65536",
        "woosh web --token short",
        "woosh web --origin nowhere",
        "woosh vda5050 --broker mqtt://127.0.0.1:99999 --serial 1",
        "woosh vda5050 --broker nothing --serial 1",
        "woosh status --resolve nothing",
        "woosh status --lang xx",
        "rosproto topic list --resolve nothing",
        "rosproto topic hz /x --filter (",
        "rosproto topic pub /x std_msgs/String -r 0",
        "rosproto log echo --level loud",
        "rosproto log echo --match (",
        "rosproto log set /x root loud",
        "rosproto bag record -a --chunksize 1048577",
        "rosproto bag record -a --duration 0",
        "rosproto bag record -a --duration 5x",
        "rosproto bag record -e (",
        "rosproto bag record",
        "rosproto bridge --host-name",
        "woosh foxglove --origin nowhere",
        "rosproto bag play x.bag --hz 0",
        "rosproto bag play x.bag --queue 0",
        "rosproto bag play x.bag -s -1",
        "rosproto bridge --token short",
        "rosproto bridge --origin nowhere",
        "rosproto foxglove --max-clients 0",
        "rosproto tf tree --seconds -1",
        "rosproto tf echo a b --rate 0",
        "rosproto tf monitor --every 0",
        "rosproto node ping --all --timeout 0",
        "rosproto master --port -1",
    ],
)
def test_out_of_range_is_exit_code_2_before_a_master_is_asked(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The master cannot be reached: exit code 4 would say that it was asked first."""
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{unused_port()}")
    prog, *words = line.split()
    if (extra := {"web": "web", "vda5050": "fleet"}.get(words[0])) is not None:
        needs(extra)
    result = run(prog, words)
    assert result.code == 2, result.err
    assert "Traceback" not in result.err
    assert "this is a bug" not in result.err
    assert len([row for row in result.err.splitlines() if not row.startswith("usage:")]) == 1, result.err
