"""The lines of the watchdog's pipe, and when a watch is due."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.errors import RemoteProtocolError
from rosproto.watchdog import LastCall, LastMessage, LastRequest, WatchedNode, is_watchdog_name
from rosproto.watchdog.protocol import (
    PAUSES,
    ROUNDS,
    SILENCE_SECONDS,
    Arm,
    Disarm,
    Drop,
    Heartbeat,
    Line,
    Prepare,
    Ready,
    Sent,
    WatchTable,
    read_line,
    watchdog_name,
    write_line,
)

EVERY_LINE: list[Line] = [
    Prepare(
        7,
        WatchedNode("http://10.0.0.7:11311", "/laptop", "10.0.0.2", {"robot": "10.0.0.7"}, ("/defs",)),
        (LastMessage("/cmd_vel", "geometry_msgs/Twist", "Vector3 linear\n", b"\x00\xff"),),
        (LastCall("/exec_task", "woosh_msgs/ExecTask", b"\x01"),),
        (
            LastRequest(
                "http://10.0.0.7:5480/", "/stop", "{}", "/task", ("id", "7"), {"Authorization": "Basic x"}
            ),
        ),
        armed=False,
    ),
    Arm(7, (b"\x00\x80",)),
    Disarm(7),
    Drop(7),
    Heartbeat(),
    Ready(7, "nobody listens"),
    Sent((7, 8), 0.83),
]


@pytest.mark.parametrize("line", EVERY_LINE, ids=lambda line: type(line).__name__)
def test_a_line_comes_out_as_it_went_in(line: Line) -> None:
    data = write_line(line)
    assert data.endswith(b"\n")
    assert data.count(b"\n") == 1
    assert read_line(data) == line


@given(st.binary(max_size=200))
def test_anything_else_is_refused_with_the_documented_error(data: bytes) -> None:
    with pytest.raises(RemoteProtocolError):
        read_line(data)


@pytest.mark.parametrize(
    "data", [b"[]", b"{}", b'{"line": "Arm"}', b'{"line": "Prepare", "watched": 3}', b"3"]
)
def test_json_that_is_no_line_is_refused(data: bytes) -> None:
    with pytest.raises(RemoteProtocolError):
        read_line(data)


def test_a_watchdog_is_known_by_its_name_and_others_are_not() -> None:
    assert is_watchdog_name(watchdog_name("/woosh_pure_1"))
    for other in ("/safety_watchdog", "/cmd_vel_watchdog", "/woosh_pure_1"):
        assert not is_watchdog_name(other)


def rounds(table: WatchTable, now: float) -> list[tuple[float, tuple[int, ...]]]:
    """Everything that is due from now on, with its time."""
    found = []
    while (wait := table.wait(now)) is not None:
        now += wait
        if keys := table.due(now):
            found.append((round(now, 3), keys))
    return found


def test_the_end_of_the_pipe_makes_everything_armed_due_at_once_and_some_more_times() -> None:
    table = WatchTable(0.0)
    table.arm(1)
    table.arm(2)
    table.arm(3)
    table.disarm(2)
    table.end(0.1)
    times = itertools.accumulate(PAUSES, initial=0.1)
    assert rounds(table, 0.1) == [(round(time, 3), (1, 3)) for time in times]


def test_three_more_rounds_come_within_a_tenth_of_a_second() -> None:
    """The watchdog may be killed then, and the robot may have read an old velocity after the first zero."""
    assert sum(PAUSES[:3]) < 0.09


def test_nothing_is_due_while_nothing_is_armed() -> None:
    table = WatchTable(0.0)
    assert table.wait(0.0) is None
    assert table.silent(100.0) == 0.0
    table.end(100.0)
    assert rounds(table, 100.0) == []


def test_silence_is_acted_upon_once_and_again_only_after_another_sign_of_life() -> None:
    table = WatchTable(0.0)
    table.arm(1)
    assert table.wait(0.3) == pytest.approx(SILENCE_SECONDS - 0.3)
    assert table.silent(SILENCE_SECONDS - 0.01) == 0.0
    assert table.silent(SILENCE_SECONDS) == pytest.approx(SILENCE_SECONDS)
    assert len(rounds(table, SILENCE_SECONDS)) == ROUNDS
    assert table.silent(100.0) == 0.0
    table.heard(100.0)
    assert table.silent(100.5) == 0.0
    assert table.silent(101.0) == pytest.approx(1.0)


def test_a_stopped_program_that_is_then_killed_is_stopped_again() -> None:
    table = WatchTable(0.0)
    table.arm(1)
    assert table.silent(SILENCE_SECONDS)
    rounds(table, SILENCE_SECONDS)
    table.end(5.0)
    assert len(rounds(table, 5.0)) == ROUNDS


def test_what_is_disarmed_meanwhile_gets_no_more_rounds() -> None:
    table = WatchTable(0.0)
    table.arm(1)
    table.end(1.0)
    assert table.due(1.0) == (1,)
    table.disarm(1)
    assert rounds(table, 1.0) == []


def test_what_becomes_ready_after_the_end_of_the_program_is_due_too() -> None:
    table = WatchTable(0.0)
    table.end(1.0)
    table.arm(1)
    assert len(rounds(table, 1.2)) == ROUNDS
