"""startPause and stopPause (6.8.1), and the hold of an order that was restored after a restart. Pure.

A restored order is paused in the words of the standard, and its actions wait, too: nothing moves because a
program was started. stopPause continues it, cancelOrder gives it up.
"""

from __future__ import annotations

from woosh_pure.fleet.order.actions import ActionStatus
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.order_state import OrderState

__all__ = ["finish_pauses", "hold", "release"]


def hold(state: OrderState) -> None:
    """After a restart: let an order that has something to do wait for the fleet manager."""
    pending = any(not each.status.final for each in state.actions_here())
    if (pending or any(node.released for node in state.nodes)) and not state.cancelling:
        state.held = True
        text = "the vehicle's software was restarted while it carried out this order, which waits now"
        about = (("orderId", state.order_id), ("orderUpdateId", str(state.update)))
        hint = "stopPause goes on, cancelOrder gives it up"
        state.problems.set("held", Problem(ErrorType.HELD, text, about, Level.WARNING, hint))


def release(state: OrderState) -> None:
    """The order waits no more."""
    state.held = False
    state.problems.set("held", None)


def finish_pauses(state: OrderState, *, taken_back: bool = False) -> None:
    """startPause is FINISHED when the vehicle is measured standing; FAILED when it was taken back before."""
    for each in state.action_states:
        if each.action.type == "startPause" and each.status.begun and (taken_back or state.at_rest):
            each.status = ActionStatus.FAILED if taken_back else ActionStatus.FINISHED
            state.changed = True
