"""A running action, as the function that carries it out sees it, and functions of the user's own.

A function is called in a thread of its own with a `Task`; what it returns is the action's
`resultDescription`, and what it raises makes the action FAILED. It looks at `task.cancelled` from time to
time, or waits on it.
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
from typing import Any

from rosproto.sentence import say
from woosh_pure.chassis import Chassis
from woosh_pure.errors import ChassisError, GoalFailed
from woosh_pure.fleet.chassis_facts import Load
from woosh_pure.fleet.messages.elements import Action
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind


@dataclass(slots=True)
class Task:
    """A running action.

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
        """Wait for a goal of the chassis, which is cancelled with the action; returns the goal's text.

        Raises:
            GoalFailed: It ended in anything but an arrival, or nobody knows whether it ended.
        """
        while not self.cancelled.wait(0.1):
            if handle.done:
                return handle.wait(1.0).text or ""
        outcome = handle.cancel()
        if not end_is_known(outcome):
            raise GoalFailed(outcome)
        raise ChassisError("it was cancelled")


def end_is_known(outcome: Outcome) -> bool:
    """Whether the chassis has ended a goal: False where it may go on with it, because the link was lost, or
    it has not confirmed the cancel."""
    open_ended = (OutcomeKind.CONNECTION_LOST, OutcomeKind.TIMED_OUT)
    return outcome.kind not in open_ended and outcome.text != NOT_CONFIRMED


Handler = Callable[[Task], "str | None"]


# -- actions of the user's own: a Python function, or a program ----------------------------------------------

_LONGEST_RESULT = 1000
_ENDS_SECONDS = 3.0  # for a program to end when it is asked to


def handler_of(name: str, target: str) -> Handler:
    """The function that a target names.

    Raises:
        ValueError: It cannot be loaded.
    """
    return _program(target[1:]) if target.startswith("!") else _function(name, target)


def _function(name: str, target: str) -> Handler:
    module, colon, attribute = target.partition(":")
    if not colon:
        raise ValueError(
            say(
                "action {name}={target}: expected python.module:function, or !program argument ...",
                name=name,
                target=target,
            )
        )
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ValueError(
            say("action {name}={target} cannot be loaded: {error}", name=name, target=target, error=error)
        ) from error
    if not callable(found):
        raise ValueError(
            say(
                "action {name}={target}: {attribute} is no function",
                name=name,
                target=target,
                attribute=attribute,
            )
        )
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
        output = output.strip()[-_LONGEST_RESULT:]
        if process.returncode:
            raise ChassisError(
                say(
                    "{name} ended with {returncode}: {output}",
                    name=name,
                    returncode=process.returncode,
                    output=output,
                )
            )
        return output

    return run


def _command_line(command: str) -> str | list[str]:
    """Program and arguments; on Windows the line as it is, because there each program splits its own."""
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


# -- what waitForTrigger waits for ---------------------------------------------------------------------------


class Triggers:
    """Triggers that the user's own program fires through `Vehicle.trigger`."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: list[tuple[str, threading.Event]] = []

    def pull(self, name: str) -> int:
        """End every wait for this trigger; returns how many there were."""
        with self._changed:
            gone = [event for waits_for, event in self._waiting if waits_for == name]
        for event in gone:
            event.set()
        return len(gone)

    def wait(self, name: str, task: Task) -> None:
        """Wait until the trigger is fired, or the action is cancelled."""
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
