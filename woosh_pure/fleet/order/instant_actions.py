"""Instant actions: those that the order machine obeys itself, and which others are taken. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.order.actions import BUILT_IN, ActionState, ActionStatus, Scope, effective_blocking
from woosh_pure.fleet.order.cancelling import close_order
from woosh_pure.fleet.order.effects import Factsheet
from woosh_pure.fleet.order.errors import ErrorType, Problem
from woosh_pure.fleet.order.order_state import OrderState
from woosh_pure.fleet.order.pause import finish_pauses, release
from woosh_pure.fleet.order.rejection import unsupported_instant_action

__all__ = ["refuse_reused_id", "take_instant_action"]


def take_instant_action(state: OrderState, action: Action, header: int) -> None:
    """One that is not known yet: obey it, let it wait for its turn, or fail it with a problem."""
    ability = state.limits.abilities.get(action.type)
    taken = ActionState(action, Scope.INSTANT, 0, effective_blocking(action, ability))
    state.action_states.append(taken)
    state.forget_old_actions()
    problem = unsupported_instant_action(action, state.limits, header) or _conflict(state, action)
    if problem is not None:
        taken.status, taken.result = ActionStatus.FAILED, problem.description
        state.add_problem(problem)
    elif action.type in BUILT_IN:
        taken.blocking, taken.status = "NONE", ActionStatus.RUNNING
        _OBEY[action.type](state, taken)


def refuse_reused_id(state: OrderState, action: Action, known: ActionState, header: int) -> None:
    """An action with the id of another one is told as an error. What stops is obeyed all the same, because a
    fleet manager that sends it wants the vehicle to stand."""
    text = (
        f"the actionId {action.id} was used before, by {known.action.type}, which is {known.status.value}; "
        "give each action an id of its own"
    )
    if action.type == "startPause":
        state.paused = True
        text += "; the vehicle pauses all the same"
    elif action.type == "cancelOrder" and state.executing:
        if not state.cancelling:
            close_order(state)
        text += "; the order is cancelled all the same"
    about = (("topic", "instantActions"), ("headerId", str(header)))
    more = (("actionId", action.id), ("actionType", action.type), ("field", "actionId"))
    state.add_problem(Problem(ErrorType.INSTANT_ACTION, text, (*about, *more)))


def _conflict(state: OrderState, action: Action) -> Problem | None:
    """6.9: an instant action must not contradict the order, nor move in a mode that is somebody else's."""
    ability = state.limits.abilities[action.type]
    of_map = action.type == "enableMap" and action.parameters.get("mapId") in state.maps
    if not (ability.moves or action.type == "initPosition" or of_map):
        return None
    about = (("topic", "instantActions"), ("actionId", action.id), ("actionType", action.type))
    if state.executing:
        text = f"{action.type} contradicts order {state.order_id}, which is carried out; cancel it first"
        return Problem(ErrorType.INSTANT_ACTION, text, about)
    if ability.moves and not state.in_control:
        text = f"{action.type} moves the robot, and the operating mode is {state.mode}"
        return Problem(ErrorType.INSTANT_ACTION, text, about)
    return None


def _cancel_order(state: OrderState, taken: ActionState) -> None:
    if not state.executing or (state.cancelling and not state.cancels):
        taken.status, taken.result = ActionStatus.FAILED, "there is no order to cancel"
        about = (("topic", "instantActions"), ("actionId", taken.action.id))
        state.add_problem(Problem(ErrorType.NO_ORDER_TO_CANCEL, "there is no order to cancel", about))
        return
    if not state.cancelling:
        close_order(state)
    state.cancels.append(taken.action.id)


def _start_pause(state: OrderState, taken: ActionState) -> None:
    state.paused = True  # it is FINISHED when the vehicle stands: `finish_pauses`


def _stop_pause(state: OrderState, taken: ActionState) -> None:
    state.paused, taken.status = False, ActionStatus.FINISHED
    release(state)
    finish_pauses(state, taken_back=True)
    state.failures = 0
    state.blocked = False
    state.problems.set("drive", None)


def _state_request(state: OrderState, taken: ActionState) -> None:
    taken.status = ActionStatus.FINISHED


def _factsheet_request(state: OrderState, taken: ActionState) -> None:
    taken.status = ActionStatus.FINISHED
    state.effects.append(Factsheet())


_OBEY: Mapping[str, Callable[[OrderState, ActionState], None]] = {
    "cancelOrder": _cancel_order,
    "startPause": _start_pause,
    "stopPause": _stop_pause,
    "stateRequest": _state_request,
    "factsheetRequest": _factsheet_request,
}
