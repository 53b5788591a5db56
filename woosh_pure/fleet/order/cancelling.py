"""The end of an order before its last node: it was cancelled, or cleared by the operating mode. Pure.

First its actions are asked to end and the vehicle to halt; when both have ended and the vehicle was measured
standing, the order is forgotten, and the cancelOrder actions are FINISHED. An order that the operating mode
has cleared does not wait for that: a person may be driving.
"""

from __future__ import annotations

from woosh_pure.fleet.order.actions import ActionState, ActionStatus
from woosh_pure.fleet.order.effects import End
from woosh_pure.fleet.order.order_state import OrderState
from woosh_pure.fleet.order.pause import release

__all__ = ["close_order", "finish_cancelling", "forget_order", "request_end"]


def close_order(state: OrderState) -> None:
    """Ask its actions to end; its nodes are forgotten when all has ended."""
    state.closed = state.cancelling = state.changed = True
    for each in state.action_states:
        if each.of_order and not each.status.final:
            request_end(state, each, failed=True)


def request_end(state: OrderState, action: ActionState, *, failed: bool) -> None:
    """Ask an action to end; one that waits does not begin any more.

    Args:
        state: The order.
        action: The action.
        failed: False when its edge was left: that is its right end.
    """
    if action.status is ActionStatus.WAITING:
        action.status, action.result = ActionStatus.FAILED, "the order was cancelled before it began"
        return
    ability = state.limits.abilities.get(action.action.type)
    if not action.ending and (not failed or ability is None or ability.interruptible):
        action.ending = True
        state.effects.append(End(action.action.id, failed))


def finish_cancelling(state: OrderState) -> bool:
    """Forget the order when its actions have ended and the vehicle stands. Whether it was forgotten."""
    if not (state.at_rest or (not state.unknown and not state.cancels and not state.in_control)):
        return False
    if any(each.of_order and not each.status.final for each in state.action_states):
        return False
    forget_order(state, ActionStatus.FINISHED)
    return True


def forget_order(state: OrderState, cancels: ActionStatus) -> None:
    """Drop its nodes, and end the cancelOrder actions in a status."""
    state.nodes, state.edges = [], []
    state.cancelling = state.on_edge = state.blocked = False
    release(state)
    state.problems.set("drive", None)
    for each in state.action_states:
        if each.action.id in state.cancels:
            each.status = cancels
    state.cancels, state.changed = [], True
