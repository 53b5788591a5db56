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
from collections.abc import Collection, Iterable, Iterator

from woosh_pure.fleet.messages.elements import Action, Edge, Node, Order
from woosh_pure.fleet.order.action_states import Scope, objection
from woosh_pure.fleet.order.errors import ErrorType, Problem
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import Hold, OrderPhase
from woosh_pure.fleet.order.vehicle_limits import Capabilities, on_other_map, within_deviation

MAX_AHEAD = 2000  # nodes of an order that is extended and not driven


def rejection_of_new_order(order: Order, state: OrderState) -> Problem | None:
    """Why a new order is rejected; None if it is accepted."""
    return next(_against_new_order(order, state), None)


def rejection_of_update(order: Order, state: OrderState) -> Problem | None:
    """Why an update of the current order is rejected; None if it is accepted."""
    return next(_against_update(order, state), None)


def _against_new_order(order: Order, state: OrderState) -> Iterator[Problem]:
    yield from _not_kept(order, state)
    if state.executing:
        text = f"order {state.order_id} is not finished; cancel it first, or update it"
        yield _problem(order, ErrorType.ORDER, text)
    yield from _not_in_control(order, state)
    running = {a.action.id for a in state.action_states if not a.status.final}
    yield from _unsupported(order, state.limits, running, first=0)
    yield from _unconnected_maps(order, order.nodes[0].actions)
    yield from _out_of_reach(order, state)


def _against_update(order: Order, state: OrderState) -> Iterator[Problem]:
    yield from _not_kept(order, state)
    if order.update < state.update:
        text = (
            f"update {order.update} of order {order.id} is out of date: the vehicle has update {state.update}"
        )
        yield _problem(order, ErrorType.ORDER_UPDATE, text)
    if state.phase is not OrderPhase.OPEN:
        text = f"order {order.id} was cancelled or cleared; send a new order"
        yield _problem(order, ErrorType.ORDER_UPDATE, text)
    first = order.nodes[0]
    wanted = state.decision_point if state.executing else (state.last_node, state.last_sequence)
    if (first.id, first.sequence) != wanted:
        text = (
            f"an update must begin at {wanted[0]} with sequenceId {wanted[1]}, this one at {first.id} "
            f"with {first.sequence}"
        )
        yield _problem(order, ErrorType.ORDER_UPDATE, text, nodeId=first.id)
    yield from _not_in_control(order, state)
    if len(state.nodes) + len(order.nodes) > MAX_AHEAD:
        yield _problem(order, ErrorType.ORDER, f"more than {MAX_AHEAD} nodes are ahead; send it later")
    taken = state.action_states.ids() - state.ids_of_horizon()
    yield from _unsupported(order, state.limits, taken, first=1)
    stitching = [each.action for each in state.action_states.at(Scope.NODE, first.sequence)]
    yield from _unconnected_maps(order, stitching)


def _problem(order: Order, kind: str, text: str, **about: str) -> Problem:
    return Problem(kind, text, order.references | about)


def _not_kept(order: Order, state: OrderState) -> Iterator[Problem]:
    if Hold.DISK in state.holds:
        why = state.problems.get("disk")
        text = f"the order cannot be kept on disk, so it is not taken: {why.description if why else ''}"
        yield _problem(order, ErrorType.ORDER, text)


def _not_in_control(order: Order, state: OrderState) -> Iterator[Problem]:
    if not state.in_control:
        text = f"the operating mode is {state.mode}; orders are taken in AUTOMATIC"
        yield _problem(order, ErrorType.ORDER, text, operatingMode=state.mode)


def _unconnected_maps(order: Order, first_actions: Iterable[Action]) -> Iterator[Problem]:
    """Nodes that are on another map than the node before, without an initPosition between them.

    Args:
        order: The order.
        first_actions: Actions of the first node; of an update, those that are known, not those it repeats.
    """
    used = ""
    for n, node in enumerate(order.nodes):
        if node.position is not None:
            if used and node.position.map_id != used:
                text = (
                    f"node {node.id} is on the map {node.position.map_id}, and the node before leaves the "
                    f"vehicle on {used}; give that one an initPosition with this mapId"
                )
                where = f"nodes[{n}].nodePosition.mapId"
                yield _problem(
                    order, ErrorType.ORDER, text, nodeId=node.id, mapId=node.position.map_id, field=where
                )
            used = node.position.map_id
        for action in node.actions if n else first_actions:
            if action.type == "initPosition":
                used = str(action.parameters.get("mapId", used))


def _out_of_reach(order: Order, state: OrderState) -> Iterator[Problem]:
    first = order.nodes[0]
    about = {"nodeId": first.id}
    if first.position is None:
        if state.last_node == first.id:
            return
        last = state.last_node or "no node"
        text = f"the vehicle is not known to stand on {first.id}; it was last on {last}"
    elif state.position is None:
        text = "the vehicle does not know where it is; give it its position with initPosition"
    elif on_other_map(state.position, first):
        about["mapId"] = first.position.map_id
        text = (
            f"the first node {first.id} is on the map {first.position.map_id}, the vehicle on "
            f"{state.position.map_id}"
        )
    elif not within_deviation(state.position, first, state.limits, turned=False):
        where = f"{state.position.x:.2f}, {state.position.y:.2f}"
        text = f"the first node {first.id} is out of its deviation range: the vehicle is at {where}"
    else:
        return
    yield _problem(order, ErrorType.NO_ROUTE, text, **about)


def _unsupported(
    order: Order, limits: Capabilities, taken: Collection[str], *, first: int
) -> Iterator[Problem]:
    """6.6.4.2: the parts of an order that this vehicle cannot do.

    Args:
        order: The order.
        limits: The vehicle's capabilities.
        taken: Action ids that are in use.
        first: Index of the first node to check: 1 for an update, whose first node is known already.
    """
    if order.zone_set and order.zone_set != limits.zone_set:
        known = f"uses {limits.zone_set}" if limits.zone_set else "knows no zones; leave zoneSetId out"
        text = f"this vehicle {known}"
        yield _problem(order, ErrorType.ORDER, text, zoneSetId=order.zone_set, field="zoneSetId")
    for n, node in enumerate(order.nodes[first:], first):
        yield from _of_position(order, node, f"nodes[{n}].nodePosition", limits)
        yield from _of_actions(order, node.actions, Scope.NODE, limits, taken)
    for n, edge in enumerate(order.edges):
        for key, why in _edge_objections(edge):
            about = {"edgeId": edge.id, "field": f"edges[{n}].{key}"}
            yield _problem(order, ErrorType.ORDER, f"edge {edge.id}: {why}", **about)
        yield from _of_actions(order, edge.actions, Scope.EDGE, limits, taken)


def _of_position(order: Order, node: Node, field: str, limits: Capabilities) -> Iterator[Problem]:
    if node.position is None:
        if not limits.marks:
            text = f"node {node.id} has no nodePosition, which this vehicle needs"
            yield _problem(order, ErrorType.ORDER, text, nodeId=node.id, field=field)
    elif limits.maps and node.position.map_id not in limits.maps:
        here, wanted = ", ".join(sorted(limits.maps)), node.position.map_id
        text = f"node {node.id} is on the map {wanted}; ENABLED on the vehicle is {here}"
        about = {"nodeId": node.id, "field": f"{field}.mapId", "mapId": wanted}
        yield _problem(order, ErrorType.ORDER, text, **about)


def _of_actions(
    order: Order, actions: tuple[Action, ...], scope: Scope, limits: Capabilities, taken: Collection[str]
) -> Iterator[Problem]:
    for action in actions:
        about = {"actionId": action.id, "actionType": action.type}
        if action.id in taken:
            text = f"the actionId {action.id} is in use already; give each action an id of its own"
            yield _problem(order, ErrorType.ORDER, text, **about)
        found = objection(action, scope, limits.actions.get(action.type))
        if found:
            yield _problem(order, ErrorType.ORDER, found[1], **about, field=found[0])


_REFUSED = {
    "trajectory": "it plans its own way, and follows no trajectory",
    "corridor": "it plans its own way, and keeps to no corridor",
    "maxHeight": "it does not know its height with a load",
    "minHeight": "it does not know the height of its load handling",
    "direction": "it is not guided by a line",
    "maxRotationSpeed": "its turning speed cannot be limited for an edge",
}


def _edge_objections(edge: Edge) -> Iterator[tuple[str, str]]:
    """Fields that this vehicle cannot obey, and why."""
    options = edge.options
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


# -- instant actions -----------------------------------------------------------------------------------------


def instant_action_problem(action: Action, state: OrderState, header: int) -> Problem | None:
    """Why an instant action is rejected: it is not supported, contradicts the order (6.9), or would move the
    vehicle while the fleet manager is not in control."""
    supported = state.limits.actions.get(action.type)
    found = objection(action, Scope.INSTANT, supported)
    if found is not None or supported is None:
        field, text = found or ("actionType", "")
        return instant_problem(text, action, header, field=field)
    of_map = action.type == "enableMap" and action.parameters.get("mapId") in state.maps
    if not (supported.moves or action.type == "initPosition" or of_map):
        return None
    if state.executing:
        text = f"{action.type} contradicts order {state.order_id}, which is carried out; cancel it first"
        return instant_problem(text, action)
    if supported.moves and not state.in_control:
        text = f"{action.type} moves the robot, and the operating mode is {state.mode}"
        return instant_problem(text, action)
    return None


def instant_problem(text: str, action: Action, header: int | None = None, **about: str) -> Problem:
    """A problem of an instant action.

    Args:
        text: Its description.
        action: The action.
        header: headerId of its message, to be referred to; None leaves it out.
        about: Further references.
    """
    where = {"topic": "instantActions"} | ({} if header is None else {"headerId": str(header)})
    more = {"actionId": action.id, "actionType": action.type}
    return Problem(ErrorType.INSTANT_ACTION, text, where | more | about)
