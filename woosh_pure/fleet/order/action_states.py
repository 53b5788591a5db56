"""Actions: what the vehicle is able to do, how each stands, and which may begin now. Pure.

Blocking types (6.12): NONE runs beside driving and beside others; SOFT beside others, while the vehicle
stands; HARD alone, while it stands. Of several actions at one place the list is walked through in its
order: NONE and SOFT begin together, a HARD one waits until all before it have ended, and what comes behind
    it waits for it.

    before it in the list     NONE, SOFT that waits    HARD that waits
    --------------------------------------------------------------------
    all ended                 begins                   begins alone
    NONE, SOFT running        begins                   waits
    HARD waiting or running   waits                    waits
    HARD running elsewhere    waits                    waits
    others running elsewhere  begins                   waits

The vehicle drives on from a place when every action there has begun, and every SOFT and HARD one has ended.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.order.tables import ActionStatus


class Scope(str, Enum):
    """Where an action may stand."""

    NODE = "NODE"
    EDGE = "EDGE"
    INSTANT = "INSTANT"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of an ability.

    Attributes:
        key: Its name.
        kind: BOOL, NUMBER, INTEGER, FLOAT, STRING, OBJECT or ARRAY.
        optional: Whether it may be left out.
        description: Free text, for the factsheet.
        choices: The values that it may have; empty takes every one.
    """

    key: str
    kind: str = "STRING"
    optional: bool = False
    description: str = ""
    choices: tuple[str, ...] = ()


_TYPES: dict[str, tuple[type, ...]] = {
    "BOOL": (bool,), "NUMBER": (int, float), "INTEGER": (int,), "FLOAT": (int, float), "STRING": (str,),
    "OBJECT": (dict,), "ARRAY": (list,),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class SupportedAction:
    """A type of action that this vehicle can do.

    Attributes:
        type: `actionType`.
        scopes: Where it may stand.
        parameters: Those that are known; another one is rejected, because it could not be obeyed.
        blocking: Blocking types it may be given.
        moves: It moves the robot itself: it is HARD whatever was said, and not begun while paused.
        still: It moves nothing, and wants the robot to stand: HARD whatever was said.
        interruptible: Whether a cancel ends it; else the cancel waits for its end.
        description: Free text, for the factsheet.
        any_parameters: Take also parameters that are not listed.
    """

    type: str
    scopes: tuple[Scope, ...]
    parameters: tuple[Parameter, ...] = ()
    blocking: tuple[str, ...] = ("NONE", "SOFT", "HARD")
    moves: bool = False
    still: bool = False
    interruptible: bool = True
    description: str = ""
    any_parameters: bool = False


BUILT_IN = {
    supported.type: supported
    for supported in (
        SupportedAction(
            "cancelOrder",
            (Scope.INSTANT,),
            any_parameters=True,
            description="Stops, ends the order's actions, forgets the order.",
        ),
        SupportedAction(
            "startPause",
            (Scope.INSTANT,),
            any_parameters=True,
            description="Stops driving until stopPause; actions go on.",
        ),
        SupportedAction("stopPause", (Scope.INSTANT,), any_parameters=True, description="Drives on."),
        SupportedAction("stateRequest", (Scope.INSTANT,), any_parameters=True, description="Sends a state."),
        SupportedAction(
            "factsheetRequest", (Scope.INSTANT,), any_parameters=True, description="Sends the factsheet."
        ),
    )
}
"""What the order machine does itself; the vehicle adds what its chassis can."""


@dataclass(frozen=True, slots=True)
class ActionState:
    """How an action stands.

    Attributes:
        action: The action.
        scope: Where it stands.
        sequence: Of its node or edge; 0 for instant ones.
        blocking: What holds: its own type, or HARD where the ability moves the robot.
        status: How it stands.
        result: `resultDescription`.
        ending: It was asked to end.
    """

    action: Action
    scope: Scope
    sequence: int = 0
    blocking: str = "NONE"
    status: ActionStatus = ActionStatus.WAITING
    result: str = ""
    ending: bool = False

    @property
    def of_order(self) -> bool:
        """False for instant actions."""
        return self.scope is not Scope.INSTANT

    @property
    def stands_still(self) -> bool:
        """True when the vehicle must not drive while it runs."""
        return self.blocking != "NONE"

    def to_state(self) -> dict[str, Any]:
        """An entry of the state's `actionStates`."""
        found = {
            "actionId": self.action.id, "actionType": self.action.type, "actionStatus": self.status.value,
        }  # fmt: skip
        if self.action.description:
            found["actionDescription"] = self.action.description
        if self.result:
            found["resultDescription"] = self.result
        return found

    def to_json(self) -> dict[str, Any]:
        """For the disk."""
        return {
            "action": self.action.to_json(), "scope": self.scope.value, "sequence": self.sequence,
            "blocking": self.blocking, "status": self.status.value, "result": self.result,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> ActionState:
        """What `to_json` gave."""
        raw = data["action"]
        parameters = {each["key"]: each["value"] for each in raw["actionParameters"]}
        action = Action(
            raw["actionId"],
            raw["actionType"],
            raw["blockingType"],
            parameters,
            raw.get("actionDescription", ""),
        )
        return cls(
            action,
            Scope(data["scope"]),
            data["sequence"],
            data["blocking"],
            ActionStatus(data["status"]),
            data["result"],
        )


def may_begin(
    group: Sequence[ActionState], others: Iterable[ActionState], *, standing: bool
) -> list[ActionState]:
    """Those of a group, in the order of the list, that may begin now.

    Args:
        group: The actions of one place, or the instant ones.
        others: All other actions.
        standing: Whether the vehicle stands, and will until they have ended.
    """
    elsewhere = [state for state in others if state.status.begun]
    if any(state.blocking == "HARD" for state in elsewhere):
        return []
    found: list[ActionState] = []
    busy = bool(elsewhere)
    for state in group:
        if state.status.final:
            continue
        hard = state.blocking == "HARD"
        if state.status.begun:
            if hard:
                break
            busy = True
            continue
        if state.stands_still and not standing:
            break
        if hard:
            return found if busy or found else [state]
        found.append(state)
    return found


def holds_driving(group: Iterable[ActionState]) -> bool:
    """Whether the vehicle must stay where it is for them."""
    return any(
        state.status is ActionStatus.WAITING or (state.stands_still and not state.status.final)
        for state in group
    )


def objection(action: Action, scope: Scope, supported: SupportedAction | None) -> tuple[str, str] | None:
    """Why an action cannot be done by this vehicle: what of it is wrong, and a sentence; None when it can."""
    if supported is None:
        return "actionType", f"this vehicle knows no action {action.type}; its factsheet lists what it can do"
    if scope not in supported.scopes:
        places = ", ".join(each.value for each in supported.scopes)
        return "actionType", f"{action.type} cannot be of scope {scope.value}; expected {places}"
    if scope is not Scope.INSTANT and action.blocking not in supported.blocking:
        allowed = ", ".join(supported.blocking)
        return "blockingType", f"{action.type} with blockingType {action.blocking}; expected {allowed}"
    known = {parameter.key: parameter for parameter in supported.parameters}
    for key, value in action.parameters.items():
        parameter = known.get(key)
        if parameter is None:
            if supported.any_parameters:
                continue
            listed = ", ".join(known) or "none"
            return f"actionParameters.{key}", f"{action.type} takes no parameter {key}; it knows {listed}"
        wrong = isinstance(value, bool) and parameter.kind != "BOOL"
        if wrong or not isinstance(value, _TYPES[parameter.kind]):
            return f"actionParameters.{key}", f"{action.type}: {key} must be of type {parameter.kind}"
        if parameter.choices and value not in parameter.choices:
            listed = ", ".join(parameter.choices)
            return f"actionParameters.{key}", f"{action.type}: {key} {str(value)[:80]!r}; expected {listed}"
    missing = [p.key for p in supported.parameters if not p.optional and p.key not in action.parameters]
    if missing:
        return f"actionParameters.{missing[0]}", f"{action.type} needs the parameter {missing[0]}"
    return None


def effective_blocking(action: Action, supported: SupportedAction | None) -> str:
    """The blocking type that holds."""
    return "HARD" if supported is not None and (supported.moves or supported.still) else action.blocking
