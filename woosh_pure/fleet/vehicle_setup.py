"""`VehicleSetup`: a vehicle's capabilities, handlers, maps and journal, made from its configuration."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rosproto.errors import RosError
from woosh_pure.chassis import Chassis
from woosh_pure.fleet.action_handlers.custom_actions import Triggers
from woosh_pure.fleet.action_handlers.log_report import Journal
from woosh_pure.fleet.action_handlers.maps import MapStore
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.action_handlers.running_action import Handler
from woosh_pure.fleet.chassis_facts import ChassisFacts, MapEntry
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.order.vehicle_limits import Capabilities
from woosh_pure.fleet.state_file import Store
from woosh_pure.geometry import Footprint


@dataclass(frozen=True, slots=True)
class VehicleSetup:
    """The parts of a vehicle that its configuration determines.

    Attributes:
        limits: Its capabilities.
        handlers: The handler of each action type.
        facts: Its data, before the first messages of the chassis.
        triggers: The triggers of waitForTrigger.
        journal: Its events, for logReport; None if nothing is stored.
        maps: Its maps; None if the fleet manager may not change them.
    """

    limits: Capabilities
    handlers: Mapping[str, Handler]
    facts: ChassisFacts
    triggers: Triggers
    journal: Journal | None
    maps: MapStore | None


def set_up_vehicle(config: VehicleConfig, store: Store | None, report: Callable[[str], str]) -> VehicleSetup:
    """Set up a vehicle.

    Args:
        config: Its configuration.
        store: The file of its order; reports and maps are stored beside it. None stores nothing.
        report: Stores a report for a reason and returns its name.

    Raises:
        ValueError: A configured action cannot be loaded.
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
    """The footprint in the parameters of the chassis's navigation, in m in base_link; empty if there is none.

    The parameters are those of costmap_2d: `footprint`, a list of corners or its text, or `robot_radius`.
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
