"""Which orders, updates and instant actions are rejected: figure 8 and chapter 6.6.4, as a table. Pure.

    the order is ...                                              it is rejected as
    ------------------------------------------------------------------------------------------------
    malformed (checked before)                                    validationError           6.6.4.1
    any, while the state cannot be saved                          orderError                (ours)
    new, while another one runs, waits or is being cancelled      orderError                figure 8, 3
    new, while the fleet manager is not in control                orderError                6.10.6
    new, while the vehicle is not localised                       noRouteError              figure 8, 4
    new, with its first node out of reach, or on another map      noRouteError              figure 8, 4
    an update with a lower orderUpdateId                          orderUpdateError          6.6.4.3
    an update with the current orderUpdateId                      not at all: ignored       figure 8, 6
    an update of an order that was cancelled or cleared           orderUpdateError          (ours)
    an update that does not begin at the decision point           orderUpdateError          figure 8, 7
    an update of a finished order that does not begin at its end  orderUpdateError          figure 8, 8
    with fields that cannot be obeyed, or actions not known       orderError                6.6.4.2
    with an action whose id is in use                             orderError                (ours)
    with a map that is not ENABLED on the vehicle                 orderError                6.7.1, 6.6.4.2
    with nodes on two maps and no initPosition between them       orderError                6.8.1, 6.6.4.2

"Ours": by figure 8 an update of a cancelled order is accepted if it begins at the last node. Messages of
different topics may overtake each other, so an update sent before the cancel would move the robot again after
it. The fleet manager can send a new order instead.

Maps: an order may have nodes on several maps. All maps have one origin, so the coordinates do not show when
the vehicle is on the next map, and the vehicle does not know when a lift has arrived. The standard uses
initPosition as an action of a node for this ("Elevator", 6.8.1): it names the map, and after it the vehicle
is on that map. So the last node on a map must have an initPosition that names the map of the next node.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from woosh_pure.fleet.messages.elements import Action, Edge, Node, Order
from woosh_pure.fleet.order.action_states import Scope, objection
from woosh_pure.fleet.order.errors import ErrorType, Problem
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import Hold, OrderPhase
from woosh_pure.fleet.order.vehicle_limits import Capabilities, on_other_map, within_deviation

MOST_AHEAD = 2000  # nodes of an order that is extended and not driven


def rejection_of_new_order(order: Order, state: OrderState) -> Problem | None:
    """Why a new order is rejected; None if it is accepted."""
    if Hold.DISK in state.holds:
        return _not_kept(order, state)
    if state.executing:
        text = f"order {state.order_id} is not finished; cancel it first, or update it"
        return order_problem(order, ErrorType.ORDER, text)
    if not state.in_control:
        return _not_in_control(order, state)
    running = {a.action.id for a in state.action_states if not a.status.final}
    return (
        unsupported_in_order(order, state.limits, running, update=False)
        or _unconnected_maps(order, order.nodes[0].actions)
        or _out_of_reach(order, state)
    )


def rejection_of_update(order: Order, state: OrderState) -> Problem | None:
    """Why an update of the current order is rejected; None if it is accepted."""
    if Hold.DISK in state.holds:
        return _not_kept(order, state)
    if order.update < state.update:
        text = f"update {order.update} of order {order.id} comes late: {state.update} is here"
        return order_problem(order, ErrorType.ORDER_UPDATE, text)
    if state.phase is not OrderPhase.OPEN:
        text = f"order {order.id} was cancelled or cleared; send a new order"
        return order_problem(order, ErrorType.ORDER_UPDATE, text)
    first = order.nodes[0]
    wanted = state.decision_point if state.executing else (state.last_node, state.last_sequence)
    if (first.id, first.sequence) != wanted:
        text = (
            f"an update must begin at {wanted[0]} with sequenceId {wanted[1]}, this one at {first.id} "
            f"with {first.sequence}"
        )
        return order_problem(order, ErrorType.ORDER_UPDATE, text, ("nodeId", first.id))
    if not state.in_control:
        return _not_in_control(order, state)
    if len(state.nodes) + len(order.nodes) > MOST_AHEAD:
        return order_problem(order, ErrorType.ORDER, f"more than {MOST_AHEAD} nodes are ahead; send it later")
    taken = {a.action.id for a in state.action_states} - {a.action.id for a in state.actions_of_horizon()}
    stitching = [
        a.action for a in state.action_states if a.scope is Scope.NODE and a.sequence == first.sequence
    ]
    return unsupported_in_order(order, state.limits, taken, update=True) or _unconnected_maps(
        order, stitching
    )


def _unconnected_maps(order: Order, first_actions: Iterable[Action]) -> Problem | None:
    """The first node that is on another map than the node before, without an initPosition between them.

    Args:
        order: The order.
        first_actions: Actions of the first node; of an update, those that are known, not those it repeats.
    """
    used, actions = "", first_actions
    for n, node in enumerate(order.nodes):
        if node.position is not None:
            if used and node.position.map_id != used:
                text = (
                    f"node {node.id} is on the map {node.position.map_id}, and the node before leaves the "
                    f"vehicle on {used}; give that one an initPosition with this mapId"
                )
                about = (("nodeId", node.id), ("mapId", node.position.map_id))
                where = ("field", f"nodes[{n}].nodePosition.mapId")
                return order_problem(order, ErrorType.ORDER, text, *about, where)
            used = node.position.map_id
        for action in actions if n == 0 else node.actions:
            if action.type == "initPosition":
                used = str(action.parameters.get("mapId", used))
    return None


def _not_kept(order: Order, state: OrderState) -> Problem:
    why = state.problems.get("disk")
    text = f"the order cannot be kept on disk, so it is not taken: {why.description if why else ''}"
    return order_problem(order, ErrorType.ORDER, text)


def _not_in_control(order: Order, state: OrderState) -> Problem:
    text = f"the operating mode is {state.mode}; orders are taken in AUTOMATIC"
    return order_problem(order, ErrorType.ORDER, text, ("operatingMode", state.mode))


def _out_of_reach(order: Order, state: OrderState) -> Problem | None:
    first = order.nodes[0]
    about = ("nodeId", first.id)
    if first.position is None:
        if state.last_node == first.id:
            return None
        last = state.last_node or "no node"
        text = f"the vehicle is not known to stand on {first.id}; it was last on {last}"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    if state.position is None:
        text = "the vehicle does not know where it is; give it its position with initPosition"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    if on_other_map(state.position, first):
        wanted = first.position.map_id
        text = f"the first node {first.id} is on the map {wanted}, the vehicle on {state.position.map_id}"
        return order_problem(order, ErrorType.NO_ROUTE, text, about, ("mapId", wanted))
    if not within_deviation(state.position, first, state.limits, turned=False):
        where = f"{state.position.x:.2f}, {state.position.y:.2f}"
        text = f"the first node {first.id} is out of its deviation range: the vehicle is at {where}"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    return None


def references(order: Order, *more: tuple[str, str]) -> tuple[tuple[str, str], ...]:
    """References of a problem of an order (7.1)."""
    return (
        ("topic", "order"),
        ("headerId", str(order.header)),
        ("orderId", order.id),
        ("orderUpdateId", str(order.update)),
        *more,
    )


def order_problem(order: Order, kind: str, text: str, *more: tuple[str, str]) -> Problem:
    """A problem of an order."""
    return Problem(kind, text, references(order, *more))


def unsupported_in_order(
    order: Order, limits: Capabilities, taken: Collection[str], *, update: bool
) -> Problem | None:
    """6.6.4.2: the first part of an order that this vehicle cannot do; None if it can do all of it.

    Args:
        order: The order; the first node of an update is not checked, because it is known already.
        limits: The vehicle's capabilities.
        taken: Action ids that are in use.
        update: Whether this is an update.
    """
    first = 1 if update else 0
    if order.zone_set and order.zone_set != limits.zone_set:
        known = f"uses {limits.zone_set}" if limits.zone_set else "knows no zones; leave zoneSetId out"
        about = (("zoneSetId", order.zone_set), ("field", "zoneSetId"))
        return order_problem(order, ErrorType.ORDER, f"this vehicle {known}", *about)
    for n, node in enumerate(order.nodes[first:], first):
        found = _of_node(node, f"nodes[{n}]", limits)
        if found:
            more = (("nodeId", node.id), ("field", found[0]), *_map_of(node, found[0]))
            return order_problem(order, ErrorType.ORDER, found[1], *more)
        problem = _of_actions(order, node.actions, Scope.NODE, limits, taken)
        if problem:
            return problem
    for n, edge in enumerate(order.edges):
        found = _of_edge(edge, f"edges[{n}]")
        if found:
            return order_problem(order, ErrorType.ORDER, found[1], ("edgeId", edge.id), ("field", found[0]))
        problem = _of_actions(order, edge.actions, Scope.EDGE, limits, taken)
        if problem:
            return problem
    return None


def _of_actions(
    order: Order, actions: tuple[Action, ...], scope: Scope, limits: Capabilities, taken: Collection[str]
) -> Problem | None:
    for action in actions:
        about = (("actionId", action.id), ("actionType", action.type))
        if action.id in taken:
            text = f"the actionId {action.id} is in use already; give each action an id of its own"
            return order_problem(order, ErrorType.ORDER, text, *about)
        found = objection(action, scope, limits.actions.get(action.type))
        if found:
            return order_problem(order, ErrorType.ORDER, found[1], *about, ("field", found[0]))
    return None


def instant_action_problem(action: Action, state: OrderState, header: int) -> Problem | None:
    """Why an instant action is rejected: it is not supported, contradicts the order (6.9), or would move the
    vehicle while the fleet manager is not in control."""
    supported = state.limits.actions.get(action.type)
    found = objection(action, Scope.INSTANT, supported)
    if found is not None or supported is None:
        field, text = found or ("actionType", "")
        where = (("topic", "instantActions"), ("headerId", str(header)))
        more = (("actionId", action.id), ("actionType", action.type), ("field", field))
        return Problem(ErrorType.INSTANT_ACTION, text, (*where, *more))
    of_map = action.type == "enableMap" and action.parameters.get("mapId") in state.maps
    if not (supported.moves or action.type == "initPosition" or of_map):
        return None
    about = (("topic", "instantActions"), ("actionId", action.id), ("actionType", action.type))
    if state.executing:
        text = f"{action.type} contradicts order {state.order_id}, which is carried out; cancel it first"
        return Problem(ErrorType.INSTANT_ACTION, text, about)
    if supported.moves and not state.in_control:
        text = f"{action.type} moves the robot, and the operating mode is {state.mode}"
        return Problem(ErrorType.INSTANT_ACTION, text, about)
    return None


def _map_of(node: Node, field: str) -> tuple[tuple[str, str], ...]:
    return (("mapId", node.position.map_id),) if node.position is not None and field.endswith("mapId") else ()


def _of_node(node: Node, path: str, limits: Capabilities) -> tuple[str, str] | None:
    if node.position is None:
        if limits.marks:
            return None
        return f"{path}.nodePosition", f"node {node.id} has no nodePosition, which this vehicle needs"
    if limits.maps and node.position.map_id not in limits.maps:
        here = ", ".join(sorted(limits.maps))
        return (
            f"{path}.nodePosition.mapId",
            f"node {node.id} is on the map {node.position.map_id}; ENABLED on the vehicle is {here}",
        )
    return None


_REFUSED = {
    "trajectory": "it plans its own way, and follows no trajectory",
    "corridor": "it plans its own way, and keeps to no corridor",
    "maxHeight": "it does not know its height with a load",
    "minHeight": "it does not know the height of its load handling",
    "direction": "it is not guided by a line",
    "maxRotationSpeed": "its turning speed cannot be limited for an edge",
}


def _of_edge(edge: Edge, path: str) -> tuple[str, str] | None:
    found = next(_edge_objections(edge.options), None)
    return None if found is None else (f"{path}.{found[0]}", f"edge {edge.id}: {found[1]}")


def _edge_objections(options: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, why in _REFUSED.items():
        if key in options:
            yield key, f"this vehicle does not obey {key}: {why}"
    if "maxSpeed" in options and not options["maxSpeed"] > 0.0:
        yield "maxSpeed", "this vehicle cannot keep to this speed"
    if options.get("rotationAllowed") is False:
        yield "rotationAllowed", "this vehicle plans its own way, and may turn on it"
    if "orientation" in options:
        turn = abs(options["orientation"])
        tangential = options.get("orientationType", "TANGENTIAL") == "TANGENTIAL"
        if not (tangential and (turn < 0.01 or abs(turn - math.pi) < 0.01)):
            yield "orientation", "this vehicle drives forwards (0) or backwards (pi) along the edge"
