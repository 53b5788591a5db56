"""Names and states of the newer action operations in actionlib's terms."""

from __future__ import annotations

import pytest

from rosproto.gateway.rosbridge.action_mapping import ActionStatus, action_status, action_type
from rosproto.gateway.values import definition_name
from rosproto.protocol.goal_status import GoalStatus


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("std_msgs/String", "std_msgs/String"),
        ("std_msgs/msg/String", "std_msgs/String"),
        ("std_srvs/srv/SetBool", "std_srvs/SetBool"),
        ("/std_msgs//String/", "std_msgs/String"),
        ("String", "String"),
        ("a/b/c/d", "a/b/c/d"),
        ("a/other/c", "a/other/c"),
        ("", ""),
    ],
)
def test_names_of_types(given: str, name: str) -> None:
    """ROS 2's form and superfluous slashes are converted; other names are unchanged."""
    assert definition_name(given) == name


@pytest.mark.parametrize(
    "given",
    [
        "move_base_msgs/MoveBase",
        "move_base_msgs/MoveBaseAction",
        "move_base_msgs/action/MoveBase",
        "move_base_msgs/MoveBaseGoal",
        "move_base_msgs/MoveBaseActionGoal",
    ],
)
def test_names_of_actions(given: str) -> None:
    """However a client calls it, it is the action message."""
    assert action_type(given) == "move_base_msgs/MoveBaseAction"


def test_an_action_called_action() -> None:
    """An ending is not taken for a name."""
    assert action_type("p/Goal") == "p/GoalAction"
    assert action_type("p/Action") == "p/ActionAction"


def test_states() -> None:
    """Every state of actionlib has one of the client's; a number that is none is unknown."""
    told = {status: action_status(status) for status in GoalStatus}
    assert told[GoalStatus.SUCCEEDED] is ActionStatus.SUCCEEDED
    assert {s for s, t in told.items() if t is ActionStatus.CANCELED} == {
        GoalStatus.PREEMPTED,
        GoalStatus.RECALLED,
    }
    assert {s for s, t in told.items() if t is ActionStatus.ABORTED} == {
        GoalStatus.ABORTED,
        GoalStatus.REJECTED,
    }
    for status, state in told.items():
        ended = state in (
            ActionStatus.SUCCEEDED,
            ActionStatus.CANCELED,
            ActionStatus.ABORTED,
            ActionStatus.UNKNOWN,
        )
        assert ended == status.is_terminal
    assert action_status(99) is ActionStatus.UNKNOWN
