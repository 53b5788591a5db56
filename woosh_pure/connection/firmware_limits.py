"""Refuses values for which the connected firmware has no field, before anything is sent.

Action servers and services name their definition by its md5sum. The conversion to an older definition drops
values without a field silently, and a robot that does not receive "diagonally" drives somewhere else. So a
given value without a field is an error.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import rosproto
from rosproto.codec import Conversion, Message
from rosproto.sentence import say
from woosh_pure.enums import StepMode
from woosh_pure.errors import FirmwareLimit
from woosh_pure.firmware.versions import revision_of

# A kind of step needs its constant in the goal, and a diagonal one needs the field for its direction.
_STEP_CONSTANTS = {StepMode.LATERAL: "LATERAL", StepMode.DIAGONAL: "DIAGONALIZE"}


def require_message(name: str, publisher: rosproto.Publisher, message: Message) -> None:
    """Check that every subscriber has a field for each value given.

    Raises:
        FirmwareLimit: One lacks a field; nothing was sent.
    """
    _require(name, publisher.message_class, publisher.revisions.values(), message)


def require_goal(client: rosproto.ActionClient, goal: Message) -> None:
    """Check that every server has a field for each value of the goal, and knows its kinds of step.

    Raises:
        FirmwareLimit: One lacks a field or a kind of step; nothing was sent.
    """
    servers, wanted = set(client.servers), client.revisions
    classes = [cls for caller, cls in wanted.items() if caller in servers]
    if all(cls._md5sum == client.type.action_goal._md5sum for cls in classes):
        return
    require_steps(client.name, classes, goal)
    whole = client.type.action_goal(goal=goal)
    _require(client.name, client.type.action_goal, classes, whole)


def require_steps(name: str, classes: Iterable[Any], goal: Message) -> None:
    """Check that each definition has the kinds of step in a StepControlGoal.

    Raises:
        FirmwareLimit: One lacks a kind.
    """
    modes = {step.executeMode for step in getattr(goal, "stepControl", ())}
    for cls in classes:
        known = {constant.name for constant in type(cls().goal)._spec.constants}
        for mode, constant in _STEP_CONSTANTS.items():
            if mode in modes and constant not in known:
                raise limit_error(name, cls, [constant], say("no {mode} steps", mode=mode))
        if StepMode.DIAGONAL in modes and not _step_has_angle(cls):
            raise limit_error(name, cls, ["goal.stepControl.angle"], "no direction for diagonal steps")


def _step_has_angle(cls: Any) -> bool:
    library = cls._binding.library
    return any(field.name == "angle" for field in library.message("woosh_msgs/StepControl").fields)


def _require(name: str, ours: type[Message], theirs: Iterable[type[Message]], message: Message) -> None:
    for cls in theirs:
        if cls._md5sum != ours._md5sum:
            lost = Conversion(ours, cls).lost(message)
            if lost:
                raise limit_error(name, cls, lost, say("no field for {names}", names=", ".join(lost)))


def limit_error(name: str, cls: type[Message], fields: list[str], lack: str) -> FirmwareLimit:
    """Return the error; `cls` is the chassis's definition."""
    label, note = revision_of(cls)
    which = say("the {label} revision", label=label) if label else say("a revision that is not bundled")
    text = say(
        "{name}: this chassis's firmware has {lack}: it speaks {type} in {which} (md5sum {md5sum}){note}. "
        "Nothing was sent; leave that value out, or ask the vendor for newer firmware",
        name=name,
        lack=say(lack),
        type=cls._type,
        which=which,
        md5sum=cls._md5sum,
        note=f"; {note}" if note else "",
    )
    return FirmwareLimit(
        text,
        name=name,
        fields=fields,
        firmware=label,
        md5sum=cls._md5sum,
    )
