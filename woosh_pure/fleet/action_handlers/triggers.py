"""waitForTrigger: an action that ends when `Vehicle.trigger` or a configured handler fires its trigger."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from woosh_pure.errors import ChassisError
from woosh_pure.fleet.action_handlers.custom_actions import handler_of
from woosh_pure.fleet.action_handlers.running_action import Handler, Task
from woosh_pure.fleet.order.action_states import Parameter, Scope, SupportedAction


class Triggers:
    """The waitForTrigger actions that wait for `Vehicle.trigger`."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: list[tuple[str, threading.Event]] = []

    def fire(self, name: str) -> int:
        """End all waits for a trigger; return their number."""
        with self._changed:
            gone = [event for waits_for, event in self._waiting if waits_for == name]
        for event in gone:
            event.set()
        return len(gone)

    def wait(self, name: str, task: Task) -> None:
        """Wait until a trigger is fired, or the action is cancelled."""
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
