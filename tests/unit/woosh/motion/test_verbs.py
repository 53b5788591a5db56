"""Every verb hands on every option that it takes: a forgotten one would be refused nothing, and do nothing."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

from woosh_pure.enums import Direction, ExecutionMode
from woosh_pure.geometry import Pose2D
from woosh_pure.motion import verbs
from woosh_pure.motion.steps import Step
from woosh_pure.motion.task import TaskOptions
from woosh_pure.motion.verbs import MotionVerbs

GIVEN = {
    "timeout": 7.5,
    "check": False,
    "replace": True,
    "avoid": False,
    "speed": 0.125,
    "poses": (Pose2D(1.0, 2.0, 0.5),),
    "type_number": 3,
    "custom": 4,
    "direction": Direction.LOAD,
    "mark": "A1",
    "frame": "odom",
    "point_by_point": True,
    "several_turns": True,
    "degrees": True,
}
"""A value for each option of the verbs, none of them its default."""
ARGUMENTS: dict[str, tuple[Any, ...]] = {
    "go_to_mark": ("A1",),
    "task": (1,),
    "park": ("A1",),
    "charge": ("A1",),
    "carry": ("A1", Direction.LOAD),
    "go_to": (1.0, 2.0),
    "follow": ([Pose2D(1.0, 2.0)],),
    "move": (0.5,),
    "forward": (0.5,),
    "left": (90.0,),
    "right": (90.0,),
    "rotate": (720.0,),
    "strafe": (0.5,),
    "move_diagonal": (0.5, 90.0),
    "steps": ([Step.turn(9.0, 0.125)],),
}
VERBS = sorted(
    name for name, _ in inspect.getmembers(MotionVerbs, inspect.isfunction) if not name.startswith("_")
)


class Verbs(MotionVerbs):
    """The verbs without a chassis: what they hand on reaches nobody."""

    _components = None  # type: ignore[assignment]


def options(name: str) -> list[str]:
    """The options of a verb; those of `**options`, too."""
    found = inspect.signature(getattr(MotionVerbs, name)).parameters.values()
    own = [each.name for each in found if each.kind is inspect.Parameter.KEYWORD_ONLY]
    more = [each for each in found if each.kind is inspect.Parameter.VAR_KEYWORD]
    return own + (sorted(TaskOptions.__annotations__) if more else [])


def handed_on(monkeypatch: pytest.MonkeyPatch, name: str) -> tuple[Any, dict[str, Any]]:
    """What a verb called with every option hands on: what is to be done, and how."""
    calls: list[tuple[Any, dict[str, Any]]] = []
    for start in ("start_task", "start_navigation", "start_steps"):
        monkeypatch.setattr(verbs, start, lambda _, what, **how: calls.append((what, how)))
    getattr(Verbs(), name)(*ARGUMENTS[name], **{option: GIVEN[option] for option in options(name)})
    (call,) = calls
    return call


def test_every_verb_is_here() -> None:
    assert sorted(ARGUMENTS) == VERBS


@pytest.mark.parametrize("name", VERBS)
def test_every_option_is_handed_on(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    what, how = handed_on(monkeypatch, name)
    given = set(options(name))
    for option in given & {"timeout", "check", "replace", "avoid"}:
        assert how[option] == GIVEN[option], option
    for option in given & {"mark", "poses", "direction", "type_number", "custom"}:
        value = getattr(what, option)
        assert (tuple(value) if option == "poses" else value) == GIVEN[option], option
    if "speed" in given:
        assert what[0].speed == GIVEN["speed"]
    if "frame" in given:
        assert what[0].frame == GIVEN["frame"]
    if "point_by_point" in given:
        assert how["mode"] is ExecutionMode.POINT_BY_POINT
    if "degrees" in given:  # 720 degrees and 90 degrees are not radians
        assert abs(what[0].data) < 13.0
        assert abs(what[0].angle) < 2.0
    assert not given - set(GIVEN)
