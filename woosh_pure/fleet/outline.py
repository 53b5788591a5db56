"""The outline of a chassis, as its navigation knows it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from woosh_pure.geometry import Footprint

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

__all__ = ["outline_of"]

_OUTLINES = ("/move_base/global_costmap", "/move_base/local_costmap")


def outline_of(chassis: Chassis) -> tuple[tuple[float, float], ...]:
    """The outline that the navigation of a chassis has as its parameter, in m in base_link.

    By costmap_2d's own names: `footprint`, a list of corners or its text, or `robot_radius`; empty where
    there is none.
    """
    for space in _OUTLINES:
        try:
            corners = _parameter(chassis, f"{space}/footprint")
            if isinstance(corners, str):
                corners = json.loads(corners.replace("(", "[").replace(")", "]"))
            if corners:
                return Footprint.from_points(corners).points
            radius = _parameter(chassis, f"{space}/robot_radius")
            if radius:
                return Footprint.circle(float(radius)).points
        except (RosError, ValueError, TypeError):
            continue
    return ()


def _parameter(chassis: Chassis, name: str) -> Any:
    try:
        return chassis.node.params[name]
    except KeyError:
        return None
