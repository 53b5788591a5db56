"""`Task`: a running action, as its handler sees it; `ActionRunner` runs those that the order machine begins.

A handler is called with a `Task` in a thread. What it returns is the action's `resultDescription`; what it
raises makes the action FAILED. It checks `task.cancelled` from time to time, or waits on it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import get_logger
from woosh_pure.chassis import Chassis
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.errors import ChassisError, GoalFailed
from woosh_pure.fleet.chassis_facts import Load
from woosh_pure.fleet.messages.elements import Action
from woosh_pure.fleet.order.events import ActionEnded, BeginAction
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.outcome import Outcome, OutcomeKind, end_is_known

_log = get_logger("woosh_pure.fleet.action_handlers.running_action")


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

    def wait(self, handle: GoalHandle[Any]) -> str:
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


def ended_by_others(outcome: Outcome) -> bool:
    """Whether another program, or the robot itself, has cancelled or replaced a goal. A stop of the robot by
    another program is seen only by this."""
    return outcome.kind in (OutcomeKind.CANCELLED, OutcomeKind.REPLACED) and not outcome.by_us


Handler = Callable[[Task], "str | None"]


class ActionRunner:
    """The running actions of one vehicle, each in a thread. Call its methods from one thread.

    Args:
        chassis: The chassis.
        handlers: The handler of each action type.
        report: Called with an `ActionEnded` for each action, in the action's thread.

    Attributes:
        loads: The loads on the vehicle, changed by pick and drop.
    """

    def __init__(
        self,
        chassis: Chassis,
        handlers: Mapping[str, Handler],
        report: Callable[[ActionEnded], object],
    ) -> None:
        self._chassis, self._handlers, self._report = chassis, handlers, report
        self.loads: list[Load] = []
        self._tasks: dict[str, Task] = {}
        self._workers: set[threading.Thread] = set()

    def begin(self, effect: BeginAction) -> None:
        """Start an action."""
        action = effect.action
        task = Task(action, self._chassis, self.loads)
        self._tasks[action.id] = task
        worker = threading.Thread(
            target=self._work,
            args=(task, self._chassis.request()),
            name=f"woosh:action-{action.type}",
            daemon=True,
        )
        self._workers = {each for each in self._workers if each.is_alive()} | {worker}
        worker.start()

    def _work(self, task: Task, request: CallScope) -> None:
        ok, known, text, action = False, True, "", task.action
        by_others = False
        try:
            with request:
                text = str(self._handlers[action.type](task) or "")
            ok = True
        except Exception as error:
            text = str(error) or type(error).__name__
            known = not isinstance(error, (ConnectionLost, RosTimeout))
            if isinstance(error, GoalFailed):
                known, by_others = end_is_known(error.outcome), ended_by_others(error.outcome)
            if not isinstance(error, (RosError, ValueError, OSError)):
                _log.exception("! the action %s has failed", action.type)
        self._report(ActionEnded(action.id, ok, text, known, by_others))

    def forget(self, action_id: str) -> None:
        """Forget an action that has ended."""
        self._tasks.pop(action_id, None)

    def end(self, action_id: str) -> None:
        """Cancel an action."""
        task = self._tasks.get(action_id)
        if task is not None:
            task.cancelled.set()

    def end_all(self) -> None:
        """Cancel all actions."""
        for task in list(self._tasks.values()):
            task.cancelled.set()

    def join(self, timeout: float) -> None:
        """Wait until all actions have ended, at most `timeout` seconds."""
        deadline = time.monotonic() + timeout
        for worker in self._workers:
            worker.join(max(0.0, deadline - time.monotonic()))
