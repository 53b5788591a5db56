"""The server's goal states and list: commands by the table, cancels by id and time, expiry."""

from __future__ import annotations

import itertools

import pytest

from rosproto.errors import LocalProtocolError
from rosproto.protocol.goal_server import CANCELED_BY_TIME, GoalList, next_status
from rosproto.protocol.goal_status import GoalStatus

G = GoalStatus
COMMANDS = ["accept", "reject", "request_cancel", "cancel", "succeed", "abort"]
ALLOWED = {
    (G.PENDING, "accept"): G.ACTIVE,
    (G.PENDING, "reject"): G.REJECTED,
    (G.PENDING, "request_cancel"): G.RECALLING,
    (G.PENDING, "cancel"): G.RECALLED,
    (G.RECALLING, "accept"): G.PREEMPTING,
    (G.RECALLING, "reject"): G.REJECTED,
    (G.RECALLING, "cancel"): G.RECALLED,
    (G.ACTIVE, "request_cancel"): G.PREEMPTING,
    (G.ACTIVE, "cancel"): G.PREEMPTED,
    (G.ACTIVE, "succeed"): G.SUCCEEDED,
    (G.ACTIVE, "abort"): G.ABORTED,
    (G.PREEMPTING, "cancel"): G.PREEMPTED,
    (G.PREEMPTING, "succeed"): G.SUCCEEDED,
    (G.PREEMPTING, "abort"): G.ABORTED,
}


def accepted(goals: GoalList, goal_id: str, stamp: int = 10):
    record, new = goals.goal_received(goal_id, stamp, now=0.0)
    assert new
    goals.apply(record, "accept", 0.0)
    return record


@pytest.mark.parametrize(("status", "command"), list(itertools.product(GoalStatus, COMMANDS)))
def test_commands_do_what_the_table_says_and_nothing_else(status, command):
    assert next_status(status, command) == ALLOWED.get((status, command))


def test_a_command_the_state_does_not_allow_says_which_are():
    goals = GoalList()
    record, _ = goals.goal_received("a", 1, 0.0)
    with pytest.raises(
        LocalProtocolError, match="cannot succeed a goal that is PENDING; allowed now: accept"
    ):
        goals.apply(record, "succeed", 0.0)
    assert record.status is G.PENDING


def test_an_ended_goal_takes_no_command():
    goals = GoalList()
    record = accepted(goals, "a")
    goals.apply(record, "succeed", 0.0, "fine")
    with pytest.raises(LocalProtocolError, match="it has ended"):
        goals.apply(record, "abort", 0.0)
    assert (record.status, record.text) == (G.SUCCEEDED, "fine")


def test_a_repeated_goal_is_not_started_again():
    goals = GoalList()
    record = accepted(goals, "a")
    again, new = goals.goal_received("a", 10, 1.0)
    assert again is record
    assert not new
    assert record.status is G.ACTIVE


def test_a_repeated_goal_whose_cancel_was_requested_goes_on_recalling():
    goals = GoalList()
    record, _ = goals.goal_received("a", 10, 0.0)
    goals.cancel_received("a", 0, 0.0)
    assert goals.goal_received("a", 10, 0.0) == (record, False)
    assert record.status is G.RECALLING


def test_ended_goals_stay_five_seconds_and_leave():
    goals = GoalList()
    record = accepted(goals, "a")
    goals.expire(100.0)
    assert len(goals) == 1
    goals.apply(record, "succeed", 100.0)
    goals.expire(104.9)
    assert [r.goal_id for r in goals] == ["a"]
    goals.expire(105.0)
    assert len(goals) == 0


def test_a_repetition_of_an_ended_goal_prolongs_its_stay():
    goals = GoalList()
    record = accepted(goals, "a")
    goals.apply(record, "succeed", 0.0)
    goals.goal_received("a", 10, 4.0)
    goals.expire(8.0)
    assert len(goals) == 1


@pytest.mark.promise("A cancel may name a goal, a time")
@pytest.mark.parametrize(
    ("goal_id", "stamp", "canceled"),
    [
        ("", 0, ["a", "b", "c"]),  # all
        ("b", 0, ["b"]),  # that one
        ("", 20, ["a", "b"]),  # at or before
        ("c", 10, ["a", "c"]),  # that one, and all at or before
        ("x", 5, []),
    ],
)
def test_cancel_by_id_and_by_time(goal_id, stamp, canceled):
    goals = GoalList()
    for name, when in (("a", 10), ("b", 20), ("c", 30)):
        accepted(goals, name, when)
    assert [r.goal_id for r in goals.cancel_received(goal_id, stamp, 0.0)] == canceled
    assert [r.goal_id for r in goals if r.status is G.PREEMPTING] == canceled


def test_a_second_cancel_tells_the_program_nothing_new():
    goals = GoalList()
    accepted(goals, "a")
    assert goals.cancel_received("a", 0, 0.0)
    assert goals.cancel_received("a", 0, 0.0) == []


def test_a_cancel_of_a_pending_goal_recalls_it():
    goals = GoalList()
    record, _ = goals.goal_received("a", 1, 0.0)
    assert goals.cancel_received("a", 0, 0.0) == [record]
    assert record.status is G.RECALLING
    goals.apply(record, "accept", 0.0)
    assert record.status is G.PREEMPTING


@pytest.mark.promise("A cancel may name a goal, a time")
def test_a_cancel_before_its_goal_recalls_the_goal_when_it_comes():
    goals = GoalList()
    assert goals.cancel_received("a", 0, 0.0) == []
    assert [(r.goal_id, r.status) for r in goals] == [("a", G.RECALLING)]
    record, new = goals.goal_received("a", 7, 1.0)
    assert not new
    assert (record.status, record.stamp) == (G.RECALLED, 7)
    goals.expire(5.5)
    assert len(goals) == 1, "kept five seconds after its end, not after the cancel"
    goals.expire(6.0)
    assert len(goals) == 0


def test_a_cancel_whose_goal_never_comes_is_forgotten():
    goals = GoalList()
    goals.cancel_received("a", 0, 0.0)
    goals.expire(5.0)
    assert goals.goal_received("a", 7, 6.0)[1]


def test_a_goal_not_newer_than_the_latest_cancel_time_is_recalled():
    goals = GoalList()
    goals.cancel_received("", 100, 0.0)
    record, new = goals.goal_received("old", 100, 0.0)
    assert not new
    assert (record.status, record.text) == (G.RECALLED, CANCELED_BY_TIME)
    assert goals.goal_received("new", 101, 0.0)[1]
    assert goals.goal_received("unstamped", 0, 0.0)[1]


def test_a_cancel_of_everything_does_not_touch_later_goals():
    goals = GoalList()
    goals.cancel_received("", 0, 0.0)
    assert goals.goal_received("a", 1, 0.0)[1]
    assert len(goals) == 1


def test_a_flood_of_cancels_for_unknown_goals_is_bounded():
    goals = GoalList()
    accepted(goals, "real")
    for number in range(1500):
        goals.cancel_received(f"ghost{number}", 0, 0.0)
    assert len(goals) == 1001
    assert next(iter(goals)).goal_id == "real"


def test_a_goal_shows_its_id_and_status():
    """In logs and failing tests."""
    goals = GoalList()
    assert repr(accepted(goals, "a")) == "GoalRecord('a', ACTIVE)"
