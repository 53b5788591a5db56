"""Whether an order is taken: figure 8 and chapter 6.6.4 of the standard, as a table. Pure.

    the order is ...                                              it is rejected as
    ------------------------------------------------------------------------------------------------
    malformed (before it comes here)                              validationError           6.6.4.1
    new, while another is carried out, waits or is cancelled      orderError                figure 8, 3
    new, in an operating mode in which nobody may send orders     orderError                6.10.6
    new, while the vehicle does not know where it is              noRouteError              figure 8, 4
    new, with its first node out of reach                         noRouteError              figure 8, 4
    an update with a lower orderUpdateId                          orderUpdateError          6.6.4.3
    an update with the orderUpdateId that is here                 not at all: ignored       figure 8, 6
    an update of an order that was cancelled or cleared           orderUpdateError          (ours)
    an update that does not begin at the decision point           orderUpdateError          figure 8, 7
    an update of a finished order that does not begin at its end  orderUpdateError          figure 8, 8
    with fields that cannot be obeyed, or actions not known       orderError                6.6.4.2
    with an action whose id is in use                             orderError                (ours)

"Ours": figure 8 would take an update of a cancelled order, if it begins at the last node. Messages of
different topics overtake each other, so an update sent before the cancel would set the robot moving again
after it; a new order does what such an update is meant for.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from woosh_pure.fleet.messages.elements import Action, Edge, Node, Order
from woosh_pure.fleet.order.actions import Ability, Record, Scope, objection
from woosh_pure.fleet.order.errors import ErrorType, Problem

__all__ = [
    "DRIVING_MODES",
    "Limits",
    "Place",
    "Standing",
    "action_problems",
    "inability",
    "objection_to_new",
    "objection_to_update",
    "order_problem",
    "within",
]

DRIVING_MODES = ("AUTOMATIC", "SEMIAUTOMATIC")
"""Operating modes in which the fleet manager is in control."""
MOST_AHEAD = 2000  # nodes of an order that is extended and not driven


@dataclass(frozen=True, slots=True)
class Place:
    """Where the vehicle is: m and rad, in the map."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True, slots=True)
class Limits:
    """What a vehicle is able to obey.

    Attributes:
        abilities: By action type.
        maps: Ids of the maps in use; empty takes every one.
        tolerance: m within which a node counts as reached that allows no deviation.
        turn_tolerance: The same in rad.
        marks: Whether a node without a position is a mark of the chassis.
        zone_set: Id of the zone set that the chassis's map holds; "" where there is none.
        speed: Whether maxSpeed of an edge is obeyed.
        directions: Whether the direction of travel of an edge is obeyed (orientation 0 or pi, tangential).
    """

    abilities: Mapping[str, Ability] = field(default_factory=dict)
    maps: Collection[str] = ()
    tolerance: float = 0.2
    turn_tolerance: float = 0.2
    marks: bool = False
    zone_set: str = ""
    speed: bool = True
    directions: bool = True


class Standing(Protocol):
    """How a vehicle stands when an order comes; `OrderMachine` is one, and describes it."""

    limits: Limits
    order_id: str
    update: int
    last_node: str
    last_sequence: int
    nodes: list[Node]
    records: list[Record]
    mode: str
    place: Place | None
    closed: bool

    @property
    def executing(self) -> bool:
        """Whether an order is carried out."""

    @property
    def decision_point(self) -> tuple[str, int]:
        """Id and sequence of the last node of the base."""

    def horizon(self) -> list[Record]:
        """The actions of what is not released."""


def objection_to_new(order: Order, here: Standing) -> Problem | None:
    """Why a new order is not taken; None when it is."""
    if here.executing:
        text = f"order {here.order_id} is not finished; cancel it first, or update it"
        return order_problem(order, ErrorType.ORDER, text)
    if here.mode not in DRIVING_MODES:
        return _not_in_control(order, here)
    running = {r.action.id for r in here.records if not r.status.final}
    return inability(order, here.limits, running, update=False) or _out_of_reach(order, here)


def objection_to_update(order: Order, here: Standing) -> Problem | None:
    """Why an update of the order that is here is not taken; None when it is."""
    if order.update < here.update:
        text = f"update {order.update} of order {order.id} comes late: {here.update} is here"
        return order_problem(order, ErrorType.ORDER_UPDATE, text)
    if here.closed:
        text = f"order {order.id} was cancelled or cleared; send a new order"
        return order_problem(order, ErrorType.ORDER_UPDATE, text)
    first = order.nodes[0]
    wanted = here.decision_point if here.executing else (here.last_node, here.last_sequence)
    if (first.id, first.sequence) != wanted:
        text = (
            f"an update must begin at {wanted[0]} with sequenceId {wanted[1]}, this one at {first.id} "
            f"with {first.sequence}"
        )
        return order_problem(order, ErrorType.ORDER_UPDATE, text, ("nodeId", first.id))
    if here.mode not in DRIVING_MODES:
        return _not_in_control(order, here)
    if len(here.nodes) + len(order.nodes) > MOST_AHEAD:
        return order_problem(order, ErrorType.ORDER, f"more than {MOST_AHEAD} nodes are ahead; send it later")
    taken = {r.action.id for r in here.records} - {r.action.id for r in here.horizon()}
    return inability(order, here.limits, taken, update=True)


def _not_in_control(order: Order, here: Standing) -> Problem:
    text = f"the operating mode is {here.mode}; orders are taken in AUTOMATIC"
    return order_problem(order, ErrorType.ORDER, text, ("operatingMode", here.mode))


def _out_of_reach(order: Order, here: Standing) -> Problem | None:
    first = order.nodes[0]
    about = ("nodeId", first.id)
    if first.position is None:
        if here.last_node == first.id:
            return None
        last = here.last_node or "no node"
        text = f"the vehicle is not known to stand on {first.id}; it was last on {last}"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    if here.place is None:
        text = "the vehicle does not know where it is; give it its position with initPosition"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    if not within(here.place, first, here.limits, turned=False):
        where = f"{here.place.x:.2f}, {here.place.y:.2f}"
        text = f"the first node {first.id} is out of its deviation range: the vehicle is at {where}"
        return order_problem(order, ErrorType.NO_ROUTE, text, about)
    return None


def within(place: Place | None, node: Node, limits: Limits, *, turned: bool = True) -> bool:
    """Whether the vehicle stands on a node: in its deviation range, and turned as it wants."""
    position = node.position
    if place is None or position is None:
        return False
    radius = position.deviation_xy or limits.tolerance
    if math.hypot(place.x - position.x, place.y - position.y) > radius:
        return False
    if not turned or position.theta is None:
        return True
    allowed = limits.turn_tolerance if position.deviation_theta is None else position.deviation_theta
    away = abs(math.remainder(place.theta - position.theta, 2.0 * math.pi))
    return away <= max(allowed, 0.01)  # no base stands to the last bit as it was told


def references(order: Order, *more: tuple[str, str]) -> tuple[tuple[str, str], ...]:
    """What every problem of an order refers to (7.1)."""
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


def inability(order: Order, limits: Limits, taken: Collection[str], *, update: bool) -> Problem | None:
    """6.6.4.2: what of an order this vehicle cannot do; None when it can do all of it.

    Args:
        order: The order; the first node of an update is not looked at: what is known of it holds.
        limits: What it can do.
        taken: Ids of actions that are in use.
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
            return order_problem(order, ErrorType.ORDER, found[1], ("nodeId", node.id), ("field", found[0]))
        problem = _of_actions(order, node.actions, Scope.NODE, limits, taken)
        if problem:
            return problem
    for n, edge in enumerate(order.edges):
        found = _of_edge(edge, f"edges[{n}]", limits)
        if found:
            return order_problem(order, ErrorType.ORDER, found[1], ("edgeId", edge.id), ("field", found[0]))
        problem = _of_actions(order, edge.actions, Scope.EDGE, limits, taken)
        if problem:
            return problem
    return None


def _of_actions(
    order: Order, actions: tuple[Action, ...], scope: Scope, limits: Limits, taken: Collection[str]
) -> Problem | None:
    for action in actions:
        about = (("actionId", action.id), ("actionType", action.type))
        if action.id in taken:
            text = f"the actionId {action.id} is in use already; give each action an id of its own"
            return order_problem(order, ErrorType.ORDER, text, *about)
        found = objection(action, scope, limits.abilities.get(action.type))
        if found:
            return order_problem(order, ErrorType.ORDER, found[1], *about, ("field", found[0]))
    return None


def action_problems(action: Action, scope: Scope, limits: Limits, header: int) -> Problem | None:
    """Why an instant action cannot be done."""
    found = objection(action, scope, limits.abilities.get(action.type))
    if found is None:
        return None
    about = (("topic", "instantActions"), ("headerId", str(header)))
    more = (("actionId", action.id), ("actionType", action.type), ("field", found[0]))
    return Problem(ErrorType.INSTANT_ACTION, found[1], (*about, *more))


def _of_node(node: Node, path: str, limits: Limits) -> tuple[str, str] | None:
    if node.position is None:
        if limits.marks:
            return None
        return f"{path}.nodePosition", f"node {node.id} has no nodePosition, which this vehicle needs"
    if limits.maps and node.position.map_id not in limits.maps:
        here = ", ".join(sorted(limits.maps))
        return (
            f"{path}.nodePosition.mapId",
            f"node {node.id} is on the map {node.position.map_id}; the vehicle has {here}",
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


def _of_edge(edge: Edge, path: str, limits: Limits) -> tuple[str, str] | None:
    wrong = dict(_edge_objections(edge.options, limits))
    return next(((f"{path}.{key}", f"edge {edge.id}: {text}") for key, text in wrong.items()), None)


def _edge_objections(options: Mapping[str, Any], limits: Limits) -> Iterator[tuple[str, str]]:
    for key, why in _REFUSED.items():
        if key in options:
            yield key, f"this vehicle does not obey {key}: {why}"
    if "maxSpeed" in options and not (limits.speed and options["maxSpeed"] > 0.0):
        yield "maxSpeed", "this vehicle cannot keep to this speed"
    if options.get("rotationAllowed") is False:
        yield "rotationAllowed", "this vehicle plans its own way, and may turn on it"
    if "orientation" in options:
        turn = abs(options["orientation"])
        tangential = options.get("orientationType", "TANGENTIAL") == "TANGENTIAL"
        if not (limits.directions and tangential and (turn < 0.01 or abs(turn - math.pi) < 0.01)):
            yield "orientation", "this vehicle drives forwards (0) or backwards (pi) along the edge"
