"""Whatever the threaded face has, the awaited one has, with the same arguments and the same words."""

from __future__ import annotations

import inspect
import re
from typing import Any

import pytest

from woosh_pure import Chassis, aio
from woosh_pure.feed import feed
from woosh_pure.missions import Missions
from woosh_pure.motion import action_goal, motion, task
from woosh_pure.robot_api.api import RobotApi
from woosh_pure.velocity import drive as velocity

PAIRS = [
    (Chassis, aio.Chassis),
    (feed.Feed, aio.Feed),
    (motion.GoalHandle, aio.GoalHandle),
    (task.TaskHandle, aio.TaskHandle),
    (action_goal.ActionHandle, aio.ActionHandle),
    (action_goal.NavigationHandle, aio.NavigationHandle),
    (action_goal.StepHandle, aio.StepHandle),
    (velocity.Drive, aio.Drive),
    (RobotApi, aio.RobotApi),
    (Missions, aio.Missions),
]
LEFT_OUT = {
    "Chassis.aio": "the face itself",
    "Feed.connect": "of use inside only",
    "Feed.close": "closing the Chassis does it",
    "Feed.in_callback": "callbacks of the face run in the loop",
    "Feed.known_history": "`history` does not wait here",
    "Feed.opened": "of use inside only",
    "Feed.require_open": "of use inside only",
    "Feed.silence": "of use inside only",
    "Drive.abandon": "of use inside only",
    "Drive.end_again": "of use inside only",
    "Drive.end_due": "of use inside only",
    "Drive.end_now": "of use inside only",
    "Drive.finish": "leaving the block does it",
    "RobotApi.close": "closing the Chassis does it",
    "Missions.close": "closing the Chassis does it",
    "Missions.open": "the first request does it",
    "Missions.owner": "of use inside only",
}
OTHER_ARGUMENTS = {
    "wait": {"meanwhile"},  # other tasks run meanwhile; `progress()` shows how far it is
    "on": {"connect"},  # of use inside only
}
OTHER_WORDS = {
    "Chassis.connected": "it is awaited",
    "Chassis.faults": "it is awaited",
    "Chassis.node": "it is awaited",
    "Chassis.wait_until": "its example is awaited",
    "Feed.on": "the callback is called in the loop",
    "Feed.open": "it waits for the links",
    "Feed.wait_for": "`accept` is called in the loop",
    "GoalHandle.on_progress": "the callback is called in the loop",
    "TaskHandle.on_progress": "the callback is called in the loop",
    "ActionHandle.on_progress": "the callback is called in the loop",
    "NavigationHandle.on_progress": "the callback is called in the loop",
    "StepHandle.on_progress": "the callback is called in the loop",
}
"""Members whose first sentence differs, and why."""


def public(cls: type) -> set[str]:
    return {name for name in dir(cls) if not name.startswith("_")}


MEMBERS = [
    (threaded, awaited, name)
    for threaded, awaited in PAIRS
    for name in sorted(public(threaded))
    if f"{threaded.__name__}.{name}" not in LEFT_OUT
]


@pytest.mark.parametrize(
    ("threaded", "awaited", "name"), MEMBERS, ids=[f"{t.__name__}.{n}" for t, _, n in MEMBERS]
)
def test_a_member_is_there_with_the_same_arguments(threaded: type, awaited: type, name: str) -> None:
    """A verb that is new, or an argument that a verb gets, is there, too."""
    assert name in public(awaited)
    one, other = inspect.getattr_static(threaded, name), inspect.getattr_static(awaited, name)
    assert isinstance(one, property) == isinstance(other, property)
    assert inspect.getdoc(other)
    if isinstance(one, property):
        return
    wanted = {p.name: p.default for p in list(inspect.signature(one).parameters.values())[1:]}
    for left_out in OTHER_ARGUMENTS.get(name, ()):
        wanted.pop(left_out, None)
    assert {p.name: p.default for p in list(inspect.signature(other).parameters.values())[1:]} == wanted


def first_sentence(member: object) -> str:
    words = " ".join((inspect.getdoc(member) or "").partition("\n\n")[0].split())
    return re.split(r"(?<=\.)\s", words)[0]


@pytest.mark.parametrize(
    ("threaded", "awaited", "name"), MEMBERS, ids=[f"{t.__name__}.{n}" for t, _, n in MEMBERS]
)
def test_a_member_says_first_what_the_threaded_one_says(threaded: type, awaited: type, name: str) -> None:
    """One feed is not "how the base moves" on one face and "what it does" on the other."""
    one, other = (first_sentence(inspect.getattr_static(cls, name)) for cls in (threaded, awaited))
    assert (one == other) is (f"{threaded.__name__}.{name}" not in OTHER_WORDS), (one, other)


@pytest.mark.parametrize("name", sorted(LEFT_OUT))
def test_what_is_left_out_is_there_to_be_left_out(name: str) -> None:
    cls, _, member = name.partition(".")
    threaded = next(one for one, _ in PAIRS if one.__name__ == cls)
    assert member in public(threaded)


def test_a_verb_says_what_it_gives() -> None:
    """`help` and editors show the verb's own words and arguments, and what awaiting it gives."""
    signature = inspect.signature(aio.Chassis.go_to_mark)
    assert list(signature.parameters)[:2] == ["self", "mark"]
    assert signature.return_annotation == "Goal[TaskHandle]"
    assert aio.Chassis.go_to_mark.__doc__ == Chassis.go_to_mark.__doc__
    assert list(inspect.signature(aio.Chassis).parameters) == list(inspect.signature(Chassis).parameters)


def test_the_face_of_a_chassis_is_one() -> None:
    """Made on first use, without anything on the network."""
    chassis = Chassis("127.0.0.1:1")
    assert chassis.aio is chassis.aio
    assert chassis.aio.chassis is chassis
    assert "not connected yet" in repr(chassis.aio)


def test_a_verb_that_is_never_awaited_says_so() -> None:
    """Nothing was sent: that must not pass in silence."""
    robot: Any = Chassis("127.0.0.1:1").aio
    goal = [robot.go_to_mark("A1")]
    with pytest.warns(RuntimeWarning, match="go_to_mark was never awaited: nothing was sent"):
        goal.clear()
