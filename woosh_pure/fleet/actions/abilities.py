"""What a chassis can do beside driving, and actions of the user's own, each as a function that ends by
itself.

A function is called in a thread of its own with a `Task`; what it returns is the action's
`resultDescription`, what it raises makes the action FAILED. It looks at `task.cancelled` from time to time,
or waits on it.
"""

from __future__ import annotations

import importlib
import json
import shlex
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from woosh_pure.enums import Direction
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.actions.map_store import MapShelf, fetch, unpack
from woosh_pure.fleet.actions.predefined import MOVING, PARAMETERS, SCOPES
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.order.actions import BUILT_IN, Ability, Parameter, Scope
from woosh_pure.fleet.state import Load, MapEntry
from woosh_pure.geometry import Pose2D

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

__all__ = ["Doing", "Task", "Triggers", "abilities_of"]

_EVERYWHERE = (Scope.INSTANT, Scope.NODE, Scope.EDGE)
_CHARGE_SECONDS = 600.0
_LOCATE_SECONDS = 10.0
_LONGEST_RESULT = 1000
_ENDS_SECONDS = 3.0  # for a program to end when it is asked to


@dataclass(slots=True)
class Task:
    """An action that runs.

    Attributes:
        action: The action.
        chassis: The chassis; an action that moves it must be declared so (a function with `moves = True`).
        cancelled: Set when it is to end.
        loads: The loads on the vehicle; pick and drop change them.
    """

    action: Action
    chassis: Chassis
    loads: list[Load]
    cancelled: threading.Event = field(default_factory=threading.Event)

    @property
    def parameters(self) -> Mapping[str, Any]:
        """By key."""
        return self.action.parameters

    def wait(self, handle: Any) -> str:
        """Wait for a goal of the chassis, cancelled with the action; its words.

        Raises:
            GoalFailed: It ended in anything but an arrival.
        """
        while not self.cancelled.wait(0.1):
            if handle.done:
                return handle.wait(1.0).text or ""
        handle.cancel()
        raise ChassisError("it was cancelled")


Doing = Callable[[Task], "str | None"]


class Triggers:
    """What waitForTrigger waits for, where a program of the user's pulls it."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: list[tuple[str, threading.Event]] = []

    def pull(self, name: str) -> int:
        """Let go all that wait for it; how many."""
        with self._changed:
            gone = [event for waits_for, event in self._waiting if waits_for == name]
        for event in gone:
            event.set()
        return len(gone)

    def wait(self, name: str, task: Task) -> None:
        """Until it is pulled, or the action is cancelled."""
        entry = (name, threading.Event())
        with self._changed:
            self._waiting.append(entry)
        try:
            while not entry[1].wait(0.05):
                if task.cancelled.is_set():
                    raise ChassisError("it was cancelled")
        finally:
            with self._changed:
                self._waiting.remove(entry)


def abilities_of(
    config: VehicleConfig,
    *,
    shelf: MapShelf | None = None,
    report: Callable[[str], str] | None = None,
    triggers: Triggers | None = None,
) -> dict[str, tuple[Ability, Doing]]:
    """What a vehicle of this configuration can do, beside what the order machine does itself.

    Args:
        config: Of the vehicle.
        shelf: Its maps, where the fleet manager may change them.
        report: Stores a report for a reason, and gives its name; None where nothing is kept.
        triggers: What `Vehicle.trigger` pulls.

    Raises:
        ValueError: An action of the user's cannot be loaded, or has a name that is taken.
    """
    own = MapEntry(config.map_id, config.map_version)
    found: dict[str, tuple[Ability, Doing]] = {
        "initPosition": (
            _of("initPosition", still=True, description="Tells the robot where it stands."),
            lambda task: _init_position(task, shelf, own),
        )
    }
    if shelf is not None:
        found |= _of_maps(shelf)
    if report is not None:
        found["logReport"] = (
            _of("logReport", description="Stores a report on the vehicle's computer."),
            lambda task: report(str(task.parameters["reason"])),
        )
    if config.triggers:
        found["waitForTrigger"] = _waiting(config.triggers, triggers or Triggers())
    if config.undock:
        found["stopCharging"] = (
            _of("stopCharging", any_parameters=True, description=f"drives {config.undock:g} m straight"),
            lambda task: _stop_charging(task, config.undock),
        )
    if config.charger:
        places = (Scope.INSTANT, Scope.NODE)
        text = f"drives to the charger {config.charger} and charges"
        ability = Ability("startCharging", places, moves=True, any_parameters=True, description=text)
        found["startCharging"] = (ability, lambda task: _charge(task, config.charger))
    if config.marks:
        for name, direction in (("pick", Direction.LOAD), ("drop", Direction.UNLOAD)):
            ability = Ability(
                name, (Scope.NODE,), _CARRYING, moves=True, description="at the mark that stationName names"
            )
            found[name] = (ability, _carrying(direction))
    for name, target in config.actions.items():
        if name in BUILT_IN:
            raise ValueError(f"the action {name} is the standard's own, and cannot be replaced")
        doing = _loaded(name, target)
        ability = Ability(
            name,
            tuple(getattr(doing, "scopes", SCOPES.get(name, _EVERYWHERE))),
            PARAMETERS.get(name, ()),
            moves=bool(getattr(doing, "moves", name in MOVING)),
            interruptible=bool(getattr(doing, "interruptible", True)),
            description=(getattr(doing, "__doc__", None) or "").strip().partition("\n")[0],
            any_parameters=True,
        )
        found[name] = (ability, doing)
    return found


# -- the standard's ------------------------------------------------------------------------------------------

_CARRYING = (
    Parameter("stationName", description="the mark"),
    Parameter("stationType", optional=True),
    Parameter("loadType", optional=True),
    Parameter("loadId", optional=True),
    Parameter("lhd", optional=True),
)


def _of(name: str, **given: Any) -> Ability:
    """An ability of the standard's, with the scopes and parameters that it has there."""
    return Ability(name, SCOPES[name], PARAMETERS.get(name, ()), moves=name in MOVING, **given)


def _init_position(task: Task, shelf: MapShelf | None, own: MapEntry) -> str:
    given = task.parameters
    pose = Pose2D(float(given["x"]), float(given["y"]), float(given["theta"]))
    wanted = str(given["mapId"])
    if shelf is None and wanted != own.map_id:
        raise ChassisError(f"the vehicle has no map {wanted}, only {own.map_id}")
    if shelf is not None and wanted != shelf.active:
        entry = shelf.enabled(wanted)
        if entry is None:
            raise ChassisError(f"no version of map {wanted} is ENABLED on the vehicle; use enableMap first")
        shelf.put_on(task.chassis, wanted, entry.version, pose)
    else:
        task.chassis.set_pose(pose)

    def near(heard: Pose2D) -> bool:
        return heard.distance_to(pose) < 0.5 and abs(heard.angle_to(pose)) < 0.5

    task.chassis.pose.wait_for(near, _LOCATE_SECONDS)
    return f"the robot takes itself to be at {pose}"


def _of_maps(shelf: MapShelf) -> dict[str, tuple[Ability, Doing]]:
    def download(task: Task) -> str:
        given = {key: str(value) for key, value in task.parameters.items()}
        name, version = given["mapId"], given["mapVersion"]
        if shelf.find(name, version) is not None:
            raise ChassisError(f"map {name} {version} is on the vehicle already; delete it first")
        data = fetch(given["mapDownloadLink"], task.cancelled.is_set, given.get("mapHash", ""))
        grid = unpack(data)
        shelf.add(name, version, grid)
        return f"{grid.width} x {grid.height} cells of {grid.resolution:g} m"

    def enable(task: Task) -> str:
        name, version = str(task.parameters["mapId"]), str(task.parameters["mapVersion"])
        if shelf.find(name, version) is None:
            raise ChassisError(f"map {name} {version} is not on the vehicle; download it first")
        if name == shelf.active:
            shelf.put_on(task.chassis, name, version, task.chassis.pose.wait(_LOCATE_SECONDS, new=False))
        shelf.enable(name, version)
        return "in use" if name == shelf.active else "enabled; initPosition takes the robot there"

    def delete(task: Task) -> str:
        shelf.delete(str(task.parameters["mapId"]), str(task.parameters["mapVersion"]))
        return ""

    return {
        "downloadMap": (_of("downloadMap", description="Fetches a map; it is DISABLED at first."), download),
        "enableMap": (_of("enableMap", still=True, description="Uses this version of a map."), enable),
        "deleteMap": (_of("deleteMap", description="Deletes a map that is DISABLED."), delete),
    }


def _waiting(given: Mapping[str, str], triggers: Triggers) -> tuple[Ability, Doing]:
    loaded = {name: _loaded(name, target) if target else None for name, target in given.items()}
    kinds = Parameter("triggerType", choices=tuple(loaded))
    text = f"waits for one of: {', '.join(loaded)}"
    ability = Ability("waitForTrigger", SCOPES["waitForTrigger"], (kinds,), description=text)

    def wait(task: Task) -> str | None:
        name = str(task.parameters["triggerType"])
        doing = loaded[name]
        if doing is not None:
            return doing(task)
        triggers.wait(name, task)
        return None

    return ability, wait


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


def _carrying(direction: Direction) -> Doing:
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


# -- the user's own ------------------------------------------------------------------------------------------


def _loaded(name: str, target: str) -> Doing:
    return _program(target[1:]) if target.startswith("!") else _function(name, target)


def _function(name: str, target: str) -> Doing:
    module, colon, attribute = target.partition(":")
    if not colon:
        raise ValueError(f"action {name}={target}: expected python.module:function, or !program argument ...")
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"action {name}={target} cannot be loaded: {error}") from error
    if not callable(found):
        raise ValueError(f"action {name}={target}: {attribute} is no function")
    doing: Doing = found
    return doing


def _program(command: str) -> Doing:
    line = _command_line(command)
    if not line:
        raise ValueError("an action has an empty command")
    name = command.split(maxsplit=1)[0]

    def run(task: Task) -> str:
        """Runs a program of this computer."""
        given = json.dumps({"actionId": task.action.id, "parameters": dict(task.parameters)}) + "\n"
        with subprocess.Popen(
            line,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        ) as process:
            reader = threading.Thread(target=_watch, args=(process, task), daemon=True)
            reader.start()
            output, _ = process.communicate(given)
        output = output.strip()[-_LONGEST_RESULT:]
        if process.returncode:
            raise ChassisError(f"{name} ended with {process.returncode}: {output}")
        return output

    return run


def _command_line(command: str) -> str | list[str]:
    """A program's words; on Windows the line as it is, which a program takes apart itself."""
    return command.strip() if sys.platform == "win32" else shlex.split(command)


def _watch(process: subprocess.Popen[str], task: Task) -> None:
    """End the program with its action."""
    while process.poll() is None:
        if task.cancelled.wait(0.1):
            process.terminate()
            try:
                process.wait(_ENDS_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
            return
