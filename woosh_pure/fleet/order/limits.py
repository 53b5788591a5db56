"""What a vehicle is able to obey, for `rejection.py` and the factsheet. Pure."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from woosh_pure.fleet.order.actions import Ability

__all__ = ["Limits"]


@dataclass(frozen=True, slots=True)
class Limits:
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

    abilities: Mapping[str, Ability] = field(default_factory=dict)
    maps: Collection[str] = ()
    tolerance: float = 0.2
    turn_tolerance: float = 0.2
    marks: bool = False
    zone_set: str = ""
    speed: bool = True
    directions: bool = True
