"""What a vehicle of a configuration has: its abilities, and the places beside its kept order."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rosproto.errors import RosError
from woosh_pure.chassis import Chassis
from woosh_pure.fleet.action_handlers.log_report import Journal
from woosh_pure.fleet.action_handlers.map_store import MapStore
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.action_handlers.running_action import Handler
from woosh_pure.fleet.action_handlers.triggers import Triggers
from woosh_pure.fleet.chassis_facts import ChassisFacts, MapEntry
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.order.vehicle_limits import Capabilities
from woosh_pure.fleet.state_file import Store
from woosh_pure.geometry import Footprint


@dataclass(frozen=True, slots=True)
class VehicleSetup:
    """What is there before a chassis was heard.

    Attributes:
        limits: What the vehicle can obey.
        handlers: What each action type does.
        facts: What its state tells.
        triggers: What waitForTrigger waits for.
        journal: Where logReport writes; None where nothing is kept.
        maps: Its maps; None where the fleet manager may not change them.
    """

    limits: Capabilities
    handlers: Mapping[str, Handler]
    facts: ChassisFacts
    triggers: Triggers
    journal: Journal | None
    maps: MapStore | None


def set_up_vehicle(config: VehicleConfig, store: Store | None, report: Callable[[str], str]) -> VehicleSetup:
    """Make it.

    Args:
        config: Who the vehicle is and what it can do.
        store: Where its order is kept; reports and maps are kept beside it, and without it there are none.
        report: Stores a report for a reason, and gives its name.

    Raises:
        ValueError: An action of the configuration cannot be loaded.
    """
    own = MapEntry(config.map_id, config.map_version)
    journal = maps = None
    if store is not None:
        journal = Journal(store.path.parent / "logs", store.path.stem)
        if config.map_actions:
            maps = MapStore(store.path.parent / "maps" / store.path.stem, own)
    triggers = Triggers()
    found = supported_actions(config, maps=maps, report=None if store is None else report, triggers=triggers)
    limits = Capabilities(
        actions={name: supported for name, (supported, _) in found.items()},
        maps=(config.map_id,) if maps is None else maps.enabled_ids,
        tolerance=config.tolerance,
        turn_tolerance=config.turn_tolerance,
        marks=config.marks,
        zone_set=config.zone_set,
    )
    facts = ChassisFacts(
        map_id=config.map_id, maps=(own,), zone_set=config.zone_set, loads=() if config.marks else None
    )
    return VehicleSetup(
        limits, {name: handler for name, (_, handler) in found.items()}, facts, triggers, journal, maps
    )


_OUTLINES = ("/move_base/global_costmap", "/move_base/local_costmap")


def navigation_footprint(chassis: Chassis) -> tuple[tuple[float, float], ...]:
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
