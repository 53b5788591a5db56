"""The action types of the standard (6.8.1): how the factsheet declares each, and what it does."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.enums import Direction
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers.custom_actions import Triggers, handler_of, wait_for_trigger
from woosh_pure.fleet.action_handlers.maps import MapStore, fetch, unpack
from woosh_pure.fleet.action_handlers.running_action import Handler, Task
from woosh_pure.fleet.chassis_facts import Load, MapEntry
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.order.action_states import BUILT_IN, Parameter, Scope, SupportedAction
from woosh_pure.geometry import Pose2D

_EVERYWHERE = (Scope.INSTANT, Scope.NODE, Scope.EDGE)
_CHARGE_SECONDS = 600.0
_LOCATE_SECONDS = 10.0


def supported_actions(
    config: VehicleConfig,
    *,
    maps: MapStore | None = None,
    report: Callable[[str], str] | None = None,
    triggers: Triggers | None = None,
) -> dict[str, tuple[SupportedAction, Handler]]:
    """The actions of a vehicle with their handlers: predefined and configured ones, without the built-in
    ones.

    Args:
        config: The vehicle's configuration.
        maps: Its maps, if the fleet manager may change them.
        report: Stores a report for a reason and returns its name; None if nothing is stored.
        triggers: The triggers that `Vehicle.trigger` fires.

    Raises:
        ValueError: A configured action cannot be loaded, or has the name of a built-in one.
    """
    own = MapEntry(config.map_id, config.map_version)
    found: dict[str, tuple[SupportedAction, Handler]] = {
        "initPosition": (
            predefined("initPosition", still=True, description="Tells the robot where it stands."),
            lambda task: _init_position(task, maps, own),
        )
    }
    if maps is not None:
        found |= map_actions(maps)
    if report is not None:
        found["logReport"] = (
            predefined("logReport", description="Stores a report on the vehicle's computer."),
            lambda task: report(str(task.parameters["reason"])),
        )
    if config.triggers:
        found["waitForTrigger"] = wait_for_trigger(config.triggers, triggers or Triggers())
    if config.undock:
        found["stopCharging"] = (
            predefined(
                "stopCharging", any_parameters=True, description=f"drives {config.undock:g} m straight"
            ),
            lambda task: _stop_charging(task, config.undock),
        )
    if config.charger:
        places = (Scope.INSTANT, Scope.NODE)
        text = f"drives to the charger {config.charger} and charges"
        supported = SupportedAction(
            "startCharging", places, moves=True, any_parameters=True, description=text
        )
        found["startCharging"] = (supported, lambda task: _charge(task, config.charger))
    if config.marks:
        for name, direction in (("pick", Direction.LOAD), ("drop", Direction.UNLOAD)):
            supported = SupportedAction(
                name, (Scope.NODE,), _CARRYING, moves=True, description="at the mark that stationName names"
            )
            found[name] = (supported, _carrying(direction))
    for name, target in config.actions.items():
        if name in BUILT_IN:
            raise ValueError(
                say("the action {name} is the standard's own, and cannot be replaced", name=name)
            )
        handler = handler_of(name, target)
        supported = SupportedAction(
            name,
            tuple(getattr(handler, "scopes", SCOPES.get(name, _EVERYWHERE))),
            PARAMETERS.get(name, ()),
            moves=bool(getattr(handler, "moves", name in MOVING)),
            interruptible=bool(getattr(handler, "interruptible", True)),
            description=(getattr(handler, "__doc__", None) or "").strip().partition("\n")[0],
            any_parameters=True,
        )
        found[name] = (supported, handler)
    return found


# -- position, charging, loads -------------------------------------------------------------------------------

_CARRYING = (
    Parameter("stationName", description="the mark"),
    Parameter("stationType", optional=True),
    Parameter("loadType", optional=True),
    Parameter("loadId", optional=True),
    Parameter("lhd", optional=True),
)


def _init_position(task: Task, maps: MapStore | None, own: MapEntry) -> str:
    given = task.parameters
    pose = Pose2D(float(given["x"]), float(given["y"]), float(given["theta"]))
    if abs(pose.yaw) > math.pi + 1e-6:
        raise ChassisError(f"theta {pose.yaw:g}: expected an angle of -pi to pi, in rad")
    wanted = str(given["mapId"])
    if maps is None and wanted != own.map_id:
        raise ChassisError(f"the vehicle has no map {wanted}, only {own.map_id}")
    if maps is not None and wanted != maps.active:
        entry = maps.enabled(wanted)
        if entry is None:
            raise ChassisError(f"no version of map {wanted} is ENABLED on the vehicle; use enableMap first")
        maps.use(task.chassis, wanted, entry.version, pose)
    else:
        task.chassis.set_pose(pose)

    def near(heard: Pose2D) -> bool:
        return heard.distance_to(pose) < 0.5 and abs(heard.angle_to(pose)) < 0.5

    try:
        task.chassis.pose.wait_for(near, _LOCATE_SECONDS)
    except RosTimeout as error:
        known = task.chassis.pose.known
        if known is None:
            raise
        away, turned = pose.distance_to(known.value), math.degrees(abs(pose.angle_to(known.value)))
        raise ChassisError(
            f"the robot takes itself to be at {known.value}: {away:.2f} m and {turned:.0f}° away from the "
            f"pose that it was given, {pose}; look where it stands and which way it faces"
        ) from error
    return f"the robot takes itself to be at {pose}"


def _stop_charging(task: Task, distance: float) -> str:
    battery = task.chassis.battery
    if not battery.wait(10.0, new=False).charging:
        return "it was not charging"
    task.wait(task.chassis.move(distance, timeout=60.0, replace=True))
    battery.wait_for(lambda each: not each.charging, 10.0)
    return "off the charger"


def _charge(task: Task, mark: str) -> str:
    task.wait(task.chassis.charge(mark, timeout=_CHARGE_SECONDS, replace=True))
    battery = task.chassis.battery.wait_for(lambda each: each.charging, 10.0)
    return f"charging at {battery.percent} %"


def _carrying(direction: Direction) -> Handler:
    def carry(task: Task) -> str:
        given = task.parameters
        text = task.wait(task.chassis.carry(given["stationName"], direction, timeout=600.0, replace=True))
        load = Load(given.get("loadId", ""), given.get("loadType", ""), given.get("lhd", ""))
        if direction is Direction.LOAD:
            task.loads.append(load)
        else:
            del task.loads[-1:]
        return text

    return carry


# -- scopes and parameters of the predefined actions (6.8.1) -------------------------------------------------
#
# The factsheet declares a configured action with one of these names as the standard does.

_NODE, _EDGE, _INSTANT = Scope.NODE, Scope.EDGE, Scope.INSTANT
SCOPES: dict[str, tuple[Scope, ...]] = {
    "startCharging": (_INSTANT, _NODE), "stopCharging": (_INSTANT, _NODE), "initPosition": (_INSTANT, _NODE),
    "enableMap": (_INSTANT, _NODE), "downloadMap": (_INSTANT,), "deleteMap": (_INSTANT,),
    "logReport": (_INSTANT,), "pick": (_NODE, _EDGE), "drop": (_NODE, _EDGE), "detectObject": (_NODE, _EDGE),
    "finePositioning": (_NODE, _EDGE), "waitForTrigger": (_NODE,),
}  # fmt: skip
_MAP = (Parameter("mapId"), Parameter("mapVersion"))
_LOAD = (
    Parameter("lhd", optional=True), Parameter("stationName", optional=True),
    Parameter("loadId", optional=True), Parameter("height", "FLOAT", optional=True),
    Parameter("depth", "FLOAT", optional=True), Parameter("side", optional=True),
)  # fmt: skip
PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    "initPosition": (
        Parameter("x", "FLOAT"), Parameter("y", "FLOAT"), Parameter("theta", "FLOAT"), Parameter("mapId"),
        Parameter("lastNodeId", optional=True),
    ),
    "enableMap": _MAP, "deleteMap": _MAP,
    "downloadMap": (
        *_MAP, Parameter("mapDownloadLink", description="http(s), a ZIP of a map_server YAML and picture"),
        Parameter("mapHash", optional=True, description="MD5, SHA-1, SHA-256 or SHA-512, hexadecimal"),
    ),
    "logReport": (Parameter("reason"),),
    "pick": (Parameter("stationType"), Parameter("loadType"), *_LOAD),
    "drop": (Parameter("stationType", optional=True), Parameter("loadType", optional=True), *_LOAD),
    "detectObject": (Parameter("objectType", optional=True),),
    "finePositioning": (Parameter("stationType", optional=True), Parameter("stationName", optional=True)),
    "waitForTrigger": (Parameter("triggerType"),),
}  # fmt: skip
MOVING = frozenset(("startCharging", "stopCharging", "pick", "drop", "finePositioning"))
"""Actions that move the robot, unless the handler has its own `moves`."""


def predefined(name: str, **given: Any) -> SupportedAction:
    """A predefined action with the scopes and parameters of the standard."""
    return SupportedAction(name, SCOPES[name], PARAMETERS.get(name, ()), moves=name in MOVING, **given)


# -- downloadMap, enableMap, deleteMap (6.7, 6.8.1) ----------------------------------------------------------

_POSE_SECONDS = 10.0


def map_actions(maps: MapStore) -> dict[str, tuple[SupportedAction, Handler]]:
    """downloadMap, enableMap and deleteMap for a vehicle's maps."""

    def download(task: Task) -> str:
        given = {key: str(value) for key, value in task.parameters.items()}
        name, version = given["mapId"], given["mapVersion"]
        maps.require_room(name, version)
        data = fetch(given["mapDownloadLink"], task.cancelled.is_set, given.get("mapHash", ""))
        grid = unpack(data)
        maps.add(name, version, grid)
        return f"{grid.width} x {grid.height} cells of {grid.resolution:g} m"

    def enable(task: Task) -> str:
        name, version = str(task.parameters["mapId"]), str(task.parameters["mapVersion"])
        maps.require_stored(name, version)
        if name == maps.active:
            maps.use(task.chassis, name, version, task.chassis.pose.wait(_POSE_SECONDS, new=False))
        maps.enable(name, version)
        return "in use" if name == maps.active else "enabled; initPosition takes the robot there"

    def delete(task: Task) -> str:
        maps.delete(str(task.parameters["mapId"]), str(task.parameters["mapVersion"]))
        return ""

    return {
        "downloadMap": (
            predefined("downloadMap", description="Fetches a map; it is DISABLED at first."),
            download,
        ),
        "enableMap": (predefined("enableMap", still=True, description="Uses this version of a map."), enable),
        "deleteMap": (predefined("deleteMap", description="Deletes a map that is DISABLED."), delete),
    }
