"""The vehicle's capabilities and position, and whether it is within the deviation range of a node. Pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.action_states import SupportedAction


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a vehicle can obey.

    Attributes:
        actions: The supported actions by `actionType`.
        maps: Ids of the ENABLED maps; empty allows all.
        tolerance: Deviation in m for nodes that allow none.
        turn_tolerance: The same in rad.
        marks: Whether a node without a position is a mark of the chassis.
        zone_set: Id of the zone set of the chassis's map; "" if there is none.
    """

    actions: Mapping[str, SupportedAction] = field(default_factory=dict)
    maps: Collection[str] = ()
    tolerance: float = 0.2
    turn_tolerance: float = 0.2
    marks: bool = False
    zone_set: str = ""


@dataclass(frozen=True, slots=True)
class AgvPosition:
    """The vehicle's position in m and rad on the map `map_id`; "" if the map is not known."""

    x: float
    y: float
    theta: float
    map_id: str = ""


def within_deviation(
    measured: AgvPosition | None, node: Node, limits: Capabilities, *, turned: bool = True
) -> bool:
    """Whether the vehicle is within the deviation range of a node, and within that of its heading if
    `turned`."""
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
    return away <= max(allowed, 0.01)  # no base turns more precisely


def on_other_map(measured: AgvPosition, node: Node) -> bool:
    """Whether a node is on another map than the vehicle. All maps have one origin (6.6.6), so the coordinates
    alone do not tell."""
    return bool(measured.map_id) and node.position is not None and node.position.map_id != measured.map_id
