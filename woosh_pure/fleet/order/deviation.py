"""Whether a vehicle is on a node: the measured position, and the deviation that a node allows. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.limits import Limits

__all__ = ["AgvPosition", "on_other_map", "within_deviation"]


@dataclass(frozen=True, slots=True)
class AgvPosition:
    """Where the vehicle is: m and rad, in the map `map_id`; "" where nobody has said which."""

    x: float
    y: float
    theta: float
    map_id: str = ""


def within_deviation(
    measured: AgvPosition | None, node: Node, limits: Limits, *, turned: bool = True
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
