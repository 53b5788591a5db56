"""The client's goal machine: every pair of state and status, and the rules beyond the table."""

from __future__ import annotations

import itertools

import pytest

from rosproto.protocol.goal_client import CommState, GoalMachine, transition_path
from rosproto.protocol.goal_status import GoalStatus

S, G = CommState, GoalStatus
WIRE_STATUSES = [g for g in GoalStatus if g is not GoalStatus.LOST]

# What rospy's actionlib does, written out by state: status -> path, None where it reports an error.
# tests/interop/test_actions_rospy.py compares the whole table with the installed actionlib.
EXPECTED = {
    (S.WAITING_FOR_GOAL_ACK, G.PREEMPTED): (S.ACTIVE, S.PREEMPTING, S.WAITING_FOR_RESULT),
    (S.WAITING_FOR_GOAL_ACK, G.REJECTED): (S.PENDING, S.WAITING_FOR_RESULT),
    (S.WAITING_FOR_GOAL_ACK, G.ACTIVE): (S.ACTIVE,),
    (S.PENDING, G.RECALLED): (S.RECALLING, S.WAITING_FOR_RESULT),
    (S.PENDING, G.PENDING): (),
    (S.ACTIVE, G.PENDING): None,
    (S.ACTIVE, G.SUCCEEDED): (S.WAITING_FOR_RESULT,),
    (S.ACTIVE, G.PREEMPTED): (S.PREEMPTING, S.WAITING_FOR_RESULT),
    (S.WAITING_FOR_CANCEL_ACK, G.ACTIVE): (),
    (S.WAITING_FOR_CANCEL_ACK, G.SUCCEEDED): (S.PREEMPTING, S.WAITING_FOR_RESULT),
    (S.RECALLING, G.PREEMPTING): (S.PREEMPTING,),
    (S.RECALLING, G.ACTIVE): None,
    (S.PREEMPTING, G.RECALLED): None,
    (S.WAITING_FOR_RESULT, G.ACTIVE): (),
    (S.WAITING_FOR_RESULT, G.PREEMPTING): None,
    (S.DONE, G.SUCCEEDED): (),
    (S.DONE, G.ACTIVE): None,
}


def machine(state: CommState = S.WAITING_FOR_GOAL_ACK) -> GoalMachine:
    goal = GoalMachine("/me-1-7.0")
    goal.state = state
    return goal


def test_every_pair_of_state_and_wire_status_has_a_cell():
    for state, status in itertools.product(CommState, WIRE_STATUSES):
        path = transition_path(state, status)
        assert path is None or all(isinstance(s, CommState) for s in path)


def test_a_path_ends_in_another_state_than_it_started():
    for state, status in itertools.product(CommState, WIRE_STATUSES):
        path = transition_path(state, status)
        assert not path or path[-1] is not state


def test_terminal_status_leads_to_waiting_for_result_or_is_illegal():
    for state, status in itertools.product(set(CommState) - {S.WAITING_FOR_RESULT, S.DONE}, WIRE_STATUSES):
        path = transition_path(state, status)
        if status.is_terminal and path is not None:
            assert path[-1] is S.WAITING_FOR_RESULT


@pytest.mark.parametrize(("pair", "path"), EXPECTED.items(), ids=lambda v: str(v))
def test_cells_written_out(pair, path):
    assert transition_path(*pair) == path


def test_a_goal_that_runs_its_course():
    goal = machine()
    assert goal.status_received(G.PENDING, "") == (S.PENDING,)
    assert goal.status_received(G.ACTIVE, "going") == (S.ACTIVE,)
    assert goal.status_received(G.ACTIVE, "going") == ()
    assert goal.status_received(G.SUCCEEDED, "there") == (S.WAITING_FOR_RESULT,)
    assert goal.result_received("result", G.SUCCEEDED, "there") == (S.DONE,)
    assert (goal.status, goal.text, goal.result, goal.done) == (G.SUCCEEDED, "there", "result", True)


@pytest.mark.promise("A result may come before any status")
def test_a_result_before_any_status_passes_every_state_on_the_way():
    goal = machine()
    assert goal.result_received("r", G.SUCCEEDED, "ok") == (S.ACTIVE, S.WAITING_FOR_RESULT, S.DONE)
    assert goal.status is G.SUCCEEDED


def test_late_status_and_second_result_after_done_change_nothing():
    goal = machine()
    goal.result_received("first", G.SUCCEEDED, "ok")
    assert goal.status_received(G.ACTIVE, "late") == ()
    assert goal.result_received("second", G.ABORTED, "no") == ()
    assert (goal.result, goal.status, goal.text) == ("first", G.SUCCEEDED, "ok")


def test_an_illegal_status_is_not_believed():
    goal = machine(S.PREEMPTING)
    goal.status = G.PREEMPTING
    assert goal.status_received(G.PENDING, "nonsense") == ()
    assert (goal.state, goal.status) == (S.PREEMPTING, G.PREEMPTING)


@pytest.mark.parametrize("number", [9, 10, 200])
def test_a_status_that_is_not_for_the_wire_is_not_believed(number):
    goal = machine(S.ACTIVE)
    assert goal.status_received(number, "") == ()
    assert goal.state is S.ACTIVE


@pytest.mark.promise("A goal that is missing from the status")
@pytest.mark.parametrize("state", [S.PENDING, S.ACTIVE, S.WAITING_FOR_CANCEL_ACK, S.RECALLING, S.PREEMPTING])
def test_a_goal_that_vanishes_from_the_array_is_lost(state):
    goal = machine(state)
    goal.server = "/server"
    assert goal.unmentioned("/server") == (S.DONE,)
    assert goal.status is G.LOST
    assert "restarted" in goal.text


@pytest.mark.promise("A goal that is missing from the status")
@pytest.mark.parametrize("state", [S.WAITING_FOR_GOAL_ACK, S.WAITING_FOR_RESULT, S.DONE])
def test_a_goal_may_be_missing_before_the_ack_and_after_its_end(state):
    goal = machine(state)
    goal.server = "/server"
    assert goal.unmentioned("/server") == ()
    assert goal.state is state


def test_the_array_of_another_server_does_not_lose_the_goal():
    goal = machine()
    goal.status_received(G.ACTIVE, "", "/server")
    assert goal.unmentioned("/another") == ()
    assert goal.state is S.ACTIVE


def test_only_the_server_that_acknowledged_first_is_believed():
    goal = machine()
    goal.status_received(G.ACTIVE, "mine", "/server")
    assert goal.status_received(G.REJECTED, "not mine", "/another") == ()
    assert goal.result_received("theirs", G.REJECTED, "", "/another") == ()
    assert (goal.state, goal.text) == (S.ACTIVE, "mine")
    goal.result_received("ours", G.SUCCEEDED, "", "/server")
    assert goal.result == "ours"


@pytest.mark.parametrize("state", [S.WAITING_FOR_GOAL_ACK, S.PENDING, S.ACTIVE, S.WAITING_FOR_CANCEL_ACK])
def test_cancel_waits_for_its_acknowledgement(state):
    goal = machine(state)
    assert goal.cancel_helps
    assert goal.cancel_sent() == (S.WAITING_FOR_CANCEL_ACK,)


@pytest.mark.parametrize("state", [S.WAITING_FOR_RESULT, S.RECALLING, S.PREEMPTING, S.DONE])
def test_cancel_where_it_cannot_help_changes_nothing(state):
    goal = machine(state)
    assert not goal.cancel_helps
    assert goal.cancel_sent() == ()
    assert goal.state is state


def test_recall_of_a_pending_goal():
    goal = machine()
    goal.status_received(G.PENDING, "")
    goal.cancel_sent()
    assert goal.status_received(G.PENDING, "") == ()
    assert goal.status_received(G.RECALLING, "") == (S.RECALLING,)
    assert goal.result_received("r", G.RECALLED, "") == (S.WAITING_FOR_RESULT, S.DONE)
    assert goal.status is G.RECALLED


def test_a_goal_that_finished_before_the_cancel_came_succeeds():
    goal = machine(S.ACTIVE)
    goal.cancel_sent()
    assert goal.result_received("r", G.SUCCEEDED, "") == (S.PREEMPTING, S.WAITING_FOR_RESULT, S.DONE)
    assert goal.status is G.SUCCEEDED


@pytest.mark.parametrize(
    ("state", "status", "believed"),
    [
        (S.ACTIVE, G.REJECTED, G.REJECTED),  # illegal, yet terminal: the server's last word
        (S.ACTIVE, G.ACTIVE, G.ABORTED),
        (S.PREEMPTING, G.PREEMPTING, G.PREEMPTED),
        (S.ACTIVE, 77, G.LOST),
    ],
)
def test_a_result_ends_the_goal_whatever_its_status_says(state, status, believed):
    goal = machine(state)
    assert goal.result_received("r", status, "words")[-1] is S.DONE
    assert (goal.status, goal.text, goal.result) == (believed, "words", "r")


def test_losing_a_finished_goal_changes_nothing():
    goal = machine()
    goal.result_received("r", G.SUCCEEDED, "ok")
    assert goal.lose("why") == ()
    assert goal.status is G.SUCCEEDED


def test_a_goal_is_followed_at_one_server_from_its_first_word_on():
    """Another server on the same name (one that was restarted) must not end it; a nameless peer may be either."""
    goal = machine()
    assert goal.is_from("/one")
    assert goal.is_from("")
    goal.status_received(G.ACTIVE, "", "/one")
    assert goal.is_from("/one")
    assert goal.is_from("")
    assert not goal.is_from("/two")
