"""What a vehicle is able to obey, and whether it is on a node: the measured position, and the deviation that
the node allows. Pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.action_states import SupportedAction


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a vehicle is able to obey.

    Attributes:
        abilities: By action type.
        maps: Ids of the maps that are ENABLED; empty takes every one.
        tolerance: m within which a node counts as reached that allows no deviation.
        turn_tolerance: The same in rad.
        marks: Whether a node without a position is a mark of the chassis.
        zone_set: Id of the zone set that the chassis's map holds; "" where there is none.
        speed: Whether maxSpeed of an edge is obeyed.
        directions: Whether the direction of travel of an edge is obeyed (orientation 0 or pi, tangential).
    """

    actions: Mapping[str, SupportedAction] = field(default_factory=dict)
    maps: Collection[str] = ()
    tolerance: float = 0.2
    turn_tolerance: float = 0.2
    marks: bool = False
    zone_set: str = ""
    speed: bool = True
    directions: bool = True


@dataclass(frozen=True, slots=True)
class AgvPosition:
    """Where the vehicle is: m and rad, in the map `map_id`; "" where nobody has said which."""

    x: float
    y: float
    theta: float
    map_id: str = ""


def within_deviation(
    measured: AgvPosition | None, node: Node, limits: Capabilities, *, turned: bool = True
) -> bool:
    """Whether the vehicle stands on a node: in its deviation range, and turned as it wants."""
    position = node.position
    if measured is None or position is None:
        return False
    if on_other_map(measured, node):
        return False
    radius = position.deviation_xy or limits.tolerance
    if math.hypot(measured.x - position.x, measured.y - position.y) > radius:
        return False
    if not turned or position.theta is None:
        return True
    allowed = limits.turn_tolerance if position.deviation_theta is None else position.deviation_theta
    away = abs(math.remainder(measured.theta - position.theta, 2.0 * math.pi))
    return away <= max(allowed, 0.01)  # no base stands to the last bit as it was told


def on_other_map(measured: AgvPosition, node: Node) -> bool:
    """Whether a node is on another map than the vehicle. All maps have one origin (6.6.6), so that the
    coordinates of a node mean a place on every map, and only one is meant."""
    return bool(measured.map_id) and node.position is not None and node.position.map_id != measured.map_id
