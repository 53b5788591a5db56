"""Actions of the user's own: a Python function, or a program."""

from __future__ import annotations

import importlib
import json
import sys
import threading
from typing import TYPE_CHECKING

from woosh_pure.errors import ChassisError
from woosh_pure.fleet.actions.task import Handler, Task

if TYPE_CHECKING:
    import subprocess

__all__ = ["handler_of"]

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
        raise ValueError(f"action {name}={target}: expected python.module:function, or !program argument ...")
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"action {name}={target} cannot be loaded: {error}") from error
    if not callable(found):
        raise ValueError(f"action {name}={target}: {attribute} is no function")
    handler: Handler = found
    return handler


def _program(command: str) -> Handler:
    line = _command_line(command)
    if not line:
        raise ValueError("an action has an empty command")
    name = command.split(maxsplit=1)[0]

    def run(task: Task) -> str:
        """Runs a program of this computer."""
        import subprocess

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
    """Program and arguments; on Windows the line as it is, because there each program splits its own."""
    import shlex

    return command.strip() if sys.platform == "win32" else shlex.split(command)


def _watch(process: subprocess.Popen[str], task: Task) -> None:
    """Terminate the program when its action is cancelled."""
    import subprocess

    while process.poll() is None:
        if task.cancelled.wait(0.1):
            process.terminate()
            try:
                process.wait(_ENDS_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
            return
