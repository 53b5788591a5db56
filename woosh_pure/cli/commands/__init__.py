"""The commands, by name: `COMMANDS`.

A command `goto` consists of two functions: `add_goto(parser)` adds its arguments, and `run_goto(args, out)`
runs it and returns the exit code (None: done); slow imports belong inside the latter. To add a command, write
both and add a row here, and a place in `GROUPS` of tools/manual.py. After a change run `python -m
tools.manual`, which writes docs/commands.md and docs/commands/.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Any

from rosproto.cli import DONE
from woosh_pure.cli.output import Output

__all__ = ["COMMANDS", "add_arguments", "run"]

COMMANDS = {
    "demo": "start a simulated chassis and drive it: the first thing to try",
    "sim": "run a simulated chassis until interrupted",
    "connect": "save the address of a chassis, so that the other commands need none",
    "doctor": "find out why it does not work, in plain words; moves nothing",
    "selftest": "check that everything works on this machine; needs no robot, moves nothing, takes seconds",
    "learn": "ask the robot for its message definitions and keep what is new; moves nothing",
    "status": "show battery, pose, state, faults and whether it can move",
    "ready": "say whether it can move now, and why not (exit code 3: not ready; 5: not known)",
    "watch": "watch pose, map, scan, battery, task, faults and rates live",
    "battery": "show charge, voltage, current, temperature and health of the battery",
    "faults": "show active faults, or what a status code means (exit code 1: there are faults; 5: not known)",
    "imu": "show turning rates, accelerations and orientation",
    "scan": "show the lidar scan: the nearest obstacle, the free distance on each side, or a picture",
    "camera": "take a picture, in colour or of depth, and save it",
    "cloud": "take a point cloud of the depth camera, as a PLY file",
    "goto": "drive to a mark, or to a pose in the map",
    "task": "run a task (pick, park, charge, carry), or pause, resume, cancel the running one",
    "charge": "drive to a charger and charge",
    "mission": "run a named list of steps from a file: check, start, answer, pause, stop",
    "move": "move straight by metres (negative: backward), or sideways",
    "rotate": "turn in place by degrees (positive: to the left)",
    "drive": "drive by the keyboard: arrow keys or WASD; everything else stops",
    "stop": "stop: zero velocity and cancel everything, whoever started it (not an emergency stop)",
    "localization": "show, start or stop the localisation, or tell it where the robot is",
    "map": "save the map (PGM, YAML, and a PNG with robot, path and scan), or set another one",
    "plan": "plan a path without driving it (exit code 1: there is no path)",
    "costmap": "let obstacles enter the costmaps or not, or forget those seen so far",
    "footprint": "tell the navigation the robot's outline, for example with a load on it",
    "mode": "set what the navigation does about obstacles, and how fast it drives",
    "marks": "list the marks of the robot, and keep your own, for completion and notes",
    "api": "ask the robot something by its Robot API (JSON on port 5480); reads only",
    "led": "set the light strips: a named state, or a colour",
    "say": "let the chassis speak (where it has a voice)",
    "record": "record what the chassis sends and receives into a bag, until interrupted; moves nothing",
    "web": "show the robot in a browser, on a phone too, and serve a REST API for any language",
    "mcp": "let an assistant look at the robot, and move it within limits if you allow that",
    "foxglove": "show the chassis live in Foxglove and Lichtblick; read only unless you open something",
    "robot-api": "answer programs for the Robot API (port 5480); read only unless you open something",
    "vda5050": "connect the chassis to a fleet manager, by VDA 5050 over MQTT",
    "run": "run a program for woosh_pure or rospy, without ROS; --sim starts a simulated chassis for it",
    "shell": "open Python with `chassis` ready",
    "completion": "print what a shell needs to complete this command (bash, zsh, fish, powershell)",
}
"""One line for `woosh --help` by command."""
_MODULES = {
    "start": ("demo", "connect", "doctor", "selftest", "shell", "completion"),
    "state": ("status", "ready", "battery", "faults"),
    "devices": ("imu", "scan", "camera", "cloud", "led", "say"),
    "driving": ("goto", "task", "charge", "move", "rotate", "stop"),
    "navigation": ("localization", "plan", "costmap", "footprint", "mode"),
    "maps": ("map", "marks"),
    "bags_and_viewers": ("record", "foxglove", "robot-api"),
    "programs": ("run",),  # a module `run` would hide the function of this one
}
"""The commands of a module; every other command has a module of its own name."""
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def add_arguments(name: str, parser: ArgumentParser) -> None:
    """Add the arguments of a command."""
    _function("add", name)(parser)


def run(name: str, args: Namespace, out: Output) -> int:
    """Run a command and return the exit code."""
    code: int | None = _function("run", name)(args, out)
    return code or DONE


def _function(verb: str, name: str) -> Any:
    return getattr(
        import_module(f"{__package__}.{_MODULE_OF.get(name, name)}"), f"{verb}_{name.replace('-', '_')}"
    )
