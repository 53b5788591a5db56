"""The actions that a vehicle supports, the state of each action, and which actions may begin now. Pure.

Blocking types (6.12): NONE runs while driving and together with others; SOFT together with others, while the
vehicle stands; HARD alone, while it stands. The actions of one node or edge begin in the order of their list:
NONE and SOFT begin together, a HARD one waits until all before it have ended, and all after it wait for it.

    before it in the list     NONE, SOFT that waits    HARD that waits
    --------------------------------------------------------------------
    all ended                 begins                   begins alone
    NONE, SOFT running        begins                   waits
    HARD waiting or running   waits                    waits
    HARD running elsewhere    waits                    waits
    others running elsewhere  begins                   waits

The vehicle drives on when every action of the place has begun, and every SOFT and HARD one has ended.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple

from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.messages.parsing import read_action
from woosh_pure.fleet.order.tables import ActionStatus


class Scope(str, Enum):
    """Where an action may be used."""

    NODE = "NODE"
    EDGE = "EDGE"
    INSTANT = "INSTANT"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of an action type.

    Attributes:
        key: Its name.
        kind: BOOL, NUMBER, INTEGER, FLOAT, STRING, OBJECT or ARRAY.
        optional: Whether it may be omitted.
        description: Free text, for the factsheet.
        choices: The allowed values; empty allows all.
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
    """An action type that this vehicle supports.

    Attributes:
        type: `actionType`.
        scopes: Where it may be used.
        parameters: The known parameters; others are rejected, because they could not be obeyed.
        blocking: Allowed blocking types.
        moves: It moves the robot: always HARD, and not started while paused.
        still: It does not move the robot, but requires it to stand: always HARD.
        interruptible: Whether a cancel ends it; else the cancel waits for its end.
        description: Free text, for the factsheet.
        any_parameters: Accept parameters that are not listed, too.
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
    name: SupportedAction(name, (Scope.INSTANT,), any_parameters=True, description=text)
    for name, text in {
        "cancelOrder": "Stops, ends the order's actions, forgets the order.",
        "startPause": "Stops driving until stopPause; actions go on.",
        "stopPause": "Drives on.",
        "stateRequest": "Sends a state.",
        "factsheetRequest": "Sends the factsheet.",
    }.items()
}
"""The actions that the order machine itself carries out."""


class ActionState(NamedTuple):
    """The state of an action.

    Attributes:
        action: The action.
        scope: Whether it belongs to a node, to an edge, or is an instant action.
        sequence: Sequence id of its node or edge; 0 for instant actions.
        blocking: The effective blocking type.
        status: `actionStatus`.
        result: `resultDescription`.
        ending: It is being ended.
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
        """Whether the vehicle must stand while it runs."""
        return self.blocking != "NONE"

    def to_state(self) -> dict[str, object]:
        """An entry of the state's `actionStates`."""
        found: dict[str, object] = {
            "actionId": self.action.id, "actionType": self.action.type, "actionStatus": self.status.value,
        }  # fmt: skip
        if self.action.description:
            found["actionDescription"] = self.action.description
        if self.result:
            found["resultDescription"] = self.result
        return found

    def to_json(self) -> dict[str, object]:
        """A JSON object for the disk."""
        return {
            "action": self.action.to_json(), "scope": self.scope.value, "sequence": self.sequence,
            "blocking": self.blocking, "status": self.status.value, "result": self.result,
        }  # fmt: skip

    def change_since(self, saved: ActionState | None) -> dict[str, object]:
        """What `to_json` has changed since an earlier state; all of it if there is none of this action."""
        if saved is None or saved.action is not self.action:
            return self.to_json()
        return {"blocking": self.blocking, "status": self.status.value, "result": self.result}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> ActionState:
        """Restore from the output of `to_json`."""
        action = read_action(data["action"], "action")
        return cls(
            action,
            Scope(data["scope"]),
            data["sequence"],
            data["blocking"],
            ActionStatus(data["status"]),
            data["result"],
        )


@dataclass(frozen=True, slots=True)
class ActionStates:
    """The states of all actions, made by `of`. Each change of one makes a new value.

    An order may have 1,000 actions, and the rules ask for a few of them after every event: those of a place,
    those that run, one by its id. All of this, and a change, takes the same time for 10 and for 1,000.

    Attributes:
        all: The states in the order of their arrival.
        running: Those that run.
        open_instant: Instant actions that have not ended.
        open_of_order: Number of actions of the order that have not ended.
    """

    all: tuple[ActionState, ...] = ()
    running: tuple[ActionState, ...] = field(default=(), compare=False)
    open_instant: tuple[ActionState, ...] = field(default=(), compare=False)
    open_of_order: int = field(default=0, compare=False)
    # Indices in `all`; values whose actions are the same share them.
    _by_id: Mapping[str, int] = field(default_factory=dict, compare=False, repr=False)
    _by_place: Mapping[tuple[Scope, int], Sequence[int]] = field(
        default_factory=dict, compare=False, repr=False
    )

    @classmethod
    def of(cls, states: Iterable[ActionState]) -> ActionStates:
        """The states of other actions than before."""
        all_states = tuple(states)
        by_place: dict[tuple[Scope, int], list[int]] = {}
        for n, each in enumerate(all_states):
            if each.of_order:
                by_place.setdefault((each.scope, each.sequence), []).append(n)
        unfinished = [each for each in all_states if not each.status.final]
        return cls(
            all_states,
            tuple(each for each in unfinished if each.status.begun),
            tuple(each for each in unfinished if not each.of_order),
            sum(each.of_order for each in unfinished),
            {each.action.id: n for n, each in enumerate(all_states)},
            by_place,
        )

    def with_instant(self, new: ActionState) -> ActionStates:
        """A copy with one more instant action, which has not ended."""
        return replace(
            self,
            all=(*self.all, new),
            open_instant=(*self.open_instant, new),
            _by_id={**self._by_id, new.action.id: len(self.all)},
        )

    def with_state(self, new: ActionState) -> ActionStates:
        """A copy with another state of one of the actions."""
        n = self._by_id[new.action.id]
        old, goes_on = self.all[n], not new.status.final
        running, instant = _without(self.running, old), self.open_instant
        if not new.of_order:
            instant = tuple(new if each is old else each for each in instant if each is not old or goes_on)
        states = list(self.all)
        states[n] = new
        return ActionStates(
            tuple(states),
            (*running, new) if new.status.begun else running,
            instant,
            self.open_of_order - (new.of_order and new.status.final > old.status.final),
            self._by_id,
            self._by_place,
        )

    def get(self, action_id: str) -> ActionState | None:
        """The state of an action; None if the id is not known."""
        n = self._by_id.get(action_id)
        return None if n is None else self.all[n]

    def at(self, scope: Scope, sequence: int) -> list[ActionState]:
        """The actions of a node or edge."""
        return [self.all[n] for n in self._by_place.get((scope, sequence), ())]

    def ids(self) -> set[str]:
        """The ids of all actions."""
        return set(self._by_id)

    def in_order(self, ids: Iterable[str]) -> list[ActionState]:
        """The states of those of these actions that are known, in the order of their arrival."""
        return [self.all[n] for n in sorted(self._by_id[each] for each in ids if each in self._by_id)]

    def __iter__(self) -> Iterator[ActionState]:
        return iter(self.all)

    def __len__(self) -> int:
        return len(self.all)


def _without(states: tuple[ActionState, ...], gone: ActionState) -> tuple[ActionState, ...]:
    return tuple(each for each in states if each is not gone)


def may_begin(
    group: Sequence[ActionState], others: Iterable[ActionState], *, standing: bool
) -> list[ActionState]:
    """Return the actions of a group that may begin now, in the order of the list.

    Args:
        group: The actions of one node or edge, or the instant actions.
        others: All other actions.
        standing: Whether the vehicle stands, and will stand until they have ended.
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
    """Whether the vehicle must wait for these actions."""
    return any(
        state.status is ActionStatus.WAITING or (state.stands_still and not state.status.final)
        for state in group
    )


def objection(action: Action, scope: Scope, supported: SupportedAction | None) -> tuple[str, str] | None:
    """Why this vehicle cannot do an action: the wrong field and a sentence; None if it can."""
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
    """The blocking type in force: HARD if the vehicle must stand for the action type, else its own."""
    return "HARD" if supported is not None and (supported.moves or supported.still) else action.blocking
