"""Actions and triggers that the user configures: a Python function, or a program of this computer.

waitForTrigger is an action that ends when `Vehicle.trigger` or a configured handler fires its trigger.
"""

from __future__ import annotations

import importlib
import json
import shlex
import subprocess
import sys
import threading
from collections.abc import Mapping
from typing import Any

from rosproto.sentence import say
from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers.running_action import Handler, Task
from woosh_pure.fleet.order.action_states import Parameter, Scope, SupportedAction
from woosh_pure.missions.file import MissionFiles

_MAX_RESULT_CHARACTERS = 1000
_ENDS_SECONDS = 3.0  # for a program to end after SIGTERM


def handler_of(name: str, target: str) -> Handler:
    """Load the handler of a configured action.

    Args:
        name: The action's type, for errors.
        target: "python.module:function", "!program argument ...", or "mission:file".

    Raises:
        ValueError: It cannot be loaded.
    """
    if target.startswith("mission:"):
        return _mission(target.removeprefix("mission:"))
    return _program(target[1:]) if target.startswith("!") else _function(name, target)


def _function(name: str, target: str) -> Handler:
    module, colon, attribute = target.partition(":")
    if not colon:
        wrong = "action {name}={target}: expected python.module:function, or !program argument ..."
        raise ValueError(say(wrong, name=name, target=target))
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ValueError(
            say("action {name}={target} cannot be loaded: {error}", name=name, target=target, error=error)
        ) from error
    if not callable(found):
        wrong = "action {name}={target}: {attribute} is not a function"
        raise ValueError(say(wrong, name=name, target=target, attribute=attribute))
    handler: Handler = found
    return handler


def _program(command: str) -> Handler:
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
        output = output.strip()[-_MAX_RESULT_CHARACTERS:]
        if process.returncode:
            raise ChassisError(f"{name} ended with {process.returncode}: {output}")
        return output

    return run


def _mission(file: str) -> Handler:
    checked = MissionFiles().load(file)

    def run(task: Task) -> None:
        """Carries a mission out."""
        missions, holder = task.chassis.missions, str(task.chassis.lease.holder or "VDA 5050")
        handle = missions.run(checked, dict(task.parameters), by=holder)
        missions.wait_for(
            lambda: task.cancelled.is_set() or (handle.run is not None and handle.run.phase.over), None
        )
        if task.cancelled.is_set():
            missions.stop(by=holder)
            raise ChassisError("it was cancelled")
        handle.wait(0.0)

    handler: Any = run
    handler.moves = True
    return run


def _command_line(command: str) -> str | list[str]:
    """Program and arguments; on Windows the unchanged line, because each program splits its own."""
    return command.strip() if sys.platform == "win32" else shlex.split(command)


def _watch(process: subprocess.Popen[str], task: Task) -> None:
    """Terminate the program when its action is cancelled."""
    while process.poll() is None:
        if task.cancelled.wait(0.1):
            process.terminate()
            try:
                process.wait(_ENDS_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
            return


# -- waitForTrigger ------------------------------------------------------------------------------------------


class Triggers:
    """The waitForTrigger actions that wait for `Vehicle.trigger`."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: list[tuple[str, threading.Event]] = []

    def fire(self, name: str) -> int:
        """End all waits for a trigger; return their number."""
        with self._lock:
            gone = [event for waits_for, event in self._waiting if waits_for == name]
        for event in gone:
            event.set()
        return len(gone)

    def wait(self, name: str, task: Task) -> None:
        """Wait until a trigger is fired, or the action is cancelled."""
        entry = (name, threading.Event())
        with self._lock:
            self._waiting.append(entry)
        try:
            while not entry[1].wait(0.05):
                if task.cancelled.is_set():
                    raise ChassisError("it was cancelled")
        finally:
            with self._lock:
                self._waiting.remove(entry)


def wait_for_trigger(given: Mapping[str, str], triggers: Triggers) -> tuple[SupportedAction, Handler]:
    """The waitForTrigger action for trigger types and their configured handlers; "" waits for
    `Vehicle.trigger`."""
    loaded = {name: handler_of(name, target) if target else None for name, target in given.items()}
    kinds = Parameter("triggerType", choices=tuple(loaded))
    text = f"waits for one of: {', '.join(loaded)}"
    supported = SupportedAction("waitForTrigger", (Scope.NODE,), (kinds,), description=text)

    def wait(task: Task) -> str | None:
        name = str(task.parameters["triggerType"])
        handler = loaded[name]
        if handler is not None:
            return handler(task)
        triggers.wait(name, task)
        return None

    return supported, wait
