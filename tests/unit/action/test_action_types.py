"""The classes of an action's parts are those that its messages have, and finding them makes no message."""

from __future__ import annotations

import pytest

import rosproto
from rosproto.action.types import action_type
from rosproto.codec.generated_source import Source
from rosproto.errors import DefinitionError
from rosproto.msg.library import bundled


@pytest.mark.parametrize("value_style", ["numpy", "rospy"])
def test_the_parts_are_what_a_message_has(value_style: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cls = rosproto.message_class("move_base_msgs/MoveBaseAction", bundled().fork(), value_style=value_style)
    with monkeypatch.context() as patched:
        patched.setattr(Source, "compile", lambda *_: pytest.fail("code was generated"))
        found = action_type(cls)
    message = cls()
    goal, result, feedback = message.action_goal, message.action_result, message.action_feedback
    assert (found.action_goal, found.action_result, found.action_feedback) == (
        type(goal),
        type(result),
        type(feedback),
    )
    assert (found.goal, found.result, found.feedback) == (
        type(goal.goal),
        type(result.result),
        type(feedback.feedback),
    )
    assert (found.goal_id, found.status) == (type(goal.goal_id), type(result.status))


PART = "\n" + "=" * 80 + "\nMSG: no_msgs/Part\nint32 x\n"


@pytest.mark.parametrize(
    "definition", ["int32 action_goal\n", f"Part action_goal\n{PART}", f"Part[] action_goal\n{PART}"]
)
def test_what_is_no_action_is_refused(definition: str) -> None:
    cls = rosproto.define("no_msgs/NoAction", definition)
    with pytest.raises(DefinitionError, match="is not an action"):
        action_type(cls)
