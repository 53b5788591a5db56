"""What of the order machine outlives the process, as a JSON object, and what is made of it after a restart.
Pure.

What moved the robot may still be under way: it is stopped, and nothing begins before it was measured
standing.
What was RUNNING is FAILED then, because nobody knows how it ended; it does not begin again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from woosh_pure.fleet.messages.parsing import read_edge, read_node
from woosh_pure.fleet.order.actions import BUILT_IN, ActionState, ActionStatus
from woosh_pure.fleet.order.errors import Problem, Problems
from woosh_pure.fleet.order.order_state import OrderState
from woosh_pure.fleet.order.pause import hold

__all__ = ["order_from_json", "order_to_json"]


def order_to_json(state: OrderState) -> dict[str, Any]:
    """Everything that must outlive this process, as a JSON object."""
    return {
        "orderId": state.order_id, "orderUpdateId": state.update, "lastNodeId": state.last_node,
        "lastNodeSequenceId": state.last_sequence, "nodes": [node.to_json() for node in state.nodes],
        "edges": [edge.to_json() for edge in state.edges],
        "records": [each.to_json() for each in state.action_states],
        "problems": [problem.to_json() for problem in state.problems.of_orders], "paused": state.paused,
        "closed": state.closed, "ending": state.cancelling, "cancels": list(state.cancels),
        "driving": state.driving or state.unknown or state.is_moved_by_action(), "onEdge": state.on_edge,
    }  # fmt: skip


def order_from_json(state: OrderState, data: Mapping[str, Any]) -> None:
    """Restore a new state after an end that was not in order; what ran has failed, the order waits.

    Raises:
        Invalid, KeyError, TypeError, ValueError: This is not what `order_to_json` gave.
    """
    state.order_id, state.update = str(data["orderId"]), int(data["orderUpdateId"])
    state.last_node, state.last_sequence = str(data["lastNodeId"]), int(data["lastNodeSequenceId"])
    state.nodes = [read_node(raw, "nodes") for raw in data["nodes"]]
    state.edges = [read_edge(raw, "edges") for raw in data["edges"]]
    state.action_states = [ActionState.from_json(raw) for raw in data["records"]]
    state.problems = Problems(Problem.from_json(raw) for raw in data["problems"])
    state.paused, state.closed = bool(data["paused"]), bool(data["closed"])
    state.cancelling, state.cancels = bool(data["ending"]), list(data["cancels"])
    state.on_edge = bool(data["onEdge"])
    for each in state.action_states:
        if each.status.begun and each.action.type not in BUILT_IN:
            each.status = ActionStatus.FAILED
            each.result = "the vehicle's software was restarted while it ran"
            state.tell_failed_action(each, each.result)
    state.unknown = bool(data["driving"])  # what was sent may still be under way
    hold(state)
    state.changed = False
