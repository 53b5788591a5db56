"""`Task`: a running action, as its handler sees it.

A handler is called with a `Task` in a thread. What it returns is the action's `resultDescription`; what it
raises makes the action FAILED. It checks `task.cancelled` from time to time, or waits on it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

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
