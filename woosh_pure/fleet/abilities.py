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
from woosh_pure.fleet.actions import OWN, Ability, Parameter, Scope
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages import Action
from woosh_pure.fleet.state import Load
from woosh_pure.geometry import Pose2D

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

__all__ = ["Doing", "Task", "abilities_of"]

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


def abilities_of(config: VehicleConfig) -> dict[str, tuple[Ability, Doing]]:
    """What a vehicle of this configuration can do, beside what the order machine does itself.

    Raises:
        ValueError: An action of the user's cannot be loaded, or has a name that is taken.
    """
    found: dict[str, tuple[Ability, Doing]] = {"initPosition": (_INIT_POSITION, _init_position)}
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
        if name in OWN:
            raise ValueError(f"the action {name} is the standard's own, and cannot be replaced")
        doing = _program(target[1:]) if target.startswith("!") else _function(name, target)
        ability = Ability(
            name,
            tuple(getattr(doing, "scopes", _EVERYWHERE)),
            moves=bool(getattr(doing, "moves", False)),
            interruptible=bool(getattr(doing, "interruptible", True)),
            description=(getattr(doing, "__doc__", None) or "").strip().partition("\n")[0],
            any_parameters=True,
        )
        found[name] = (ability, doing)
    return found


# -- the standard's ------------------------------------------------------------------------------------------

_INIT_POSITION = Ability(
    "initPosition",
    (Scope.INSTANT,),
    (
        Parameter("x", "FLOAT"),
        Parameter("y", "FLOAT"),
        Parameter("theta", "FLOAT"),
        Parameter("mapId"),
        Parameter("lastNodeId", optional=True),
    ),
    description="Tells the robot where it stands.",
)
_CARRYING = (
    Parameter("stationName", description="the mark"),
    Parameter("stationType", optional=True),
    Parameter("loadType", optional=True),
    Parameter("loadId", optional=True),
    Parameter("lhd", optional=True),
)


def _init_position(task: Task) -> str:
    given = task.parameters
    pose = Pose2D(float(given["x"]), float(given["y"]), float(given["theta"]))
    task.chassis.set_pose(pose)

    def near(heard: Pose2D) -> bool:
        return heard.distance_to(pose) < 0.5 and abs(heard.angle_to(pose)) < 0.5

    task.chassis.pose.wait_for(near, _LOCATE_SECONDS)
    return f"the robot takes itself to be at {pose}"


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
