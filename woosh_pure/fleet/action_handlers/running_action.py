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
        chassis: The chassis; a handler that moves it must have the attribute `moves = True`.
        cancelled: Set when the action is to end.
        loads: The loads on the vehicle; pick and drop change them.
    """

    action: Action
    chassis: Chassis
    loads: list[Load]
    cancelled: threading.Event = field(default_factory=threading.Event)

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The action's parameters by key."""
        return self.action.parameters

    def wait(self, handle: Any) -> str:
        """Wait for a goal of the chassis and return its text. Cancelling the action cancels the goal.

        Raises:
            GoalFailed: The goal failed, or it is not known whether it has ended.
            ChassisError: The action was cancelled.
        """
        while not self.cancelled.wait(0.1):
            if handle.done:
                return handle.wait(1.0).text or ""
        outcome = handle.cancel()
        if not end_is_known(outcome):
            raise GoalFailed(outcome)
        raise ChassisError("it was cancelled")


def end_is_known(outcome: Outcome) -> bool:
    """Whether a goal has ended for certain: False if the chassis may go on with it, because the link was lost
    or the cancel was not confirmed."""
    open_ended = (OutcomeKind.CONNECTION_LOST, OutcomeKind.TIMED_OUT)
    return outcome.kind not in open_ended and outcome.text != NOT_CONFIRMED


Handler = Callable[[Task], "str | None"]
