"""`ActionRunner`: runs the actions that the order machine begins, each in a thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping

from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import get_logger
from woosh_pure.chassis import Chassis
from woosh_pure.errors import GoalFailed
from woosh_pure.fleet.action_handlers.running_action import Handler, Task, end_is_known
from woosh_pure.fleet.chassis_facts import Load
from woosh_pure.fleet.order.events import ActionEnded, BeginAction

_log = get_logger("woosh_pure.fleet.action_runner")


class ActionRunner:
    """The running actions of one vehicle. Call its methods from one thread.

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
            target=self._work, args=(task,), name=f"woosh:action-{action.type}", daemon=True
        )
        self._workers = {each for each in self._workers if each.is_alive()} | {worker}
        worker.start()

    def _work(self, task: Task) -> None:
        ok, known, text, action = False, True, "", task.action
        try:
            text = str(self._handlers[action.type](task) or "")
            ok = True
        except Exception as error:
            text = str(error) or type(error).__name__
            known = not isinstance(error, (ConnectionLost, RosTimeout))
            if isinstance(error, GoalFailed):
                known = end_is_known(error.outcome)
            if not isinstance(error, (RosError, ValueError, OSError)):
                _log.exception("! the action %s has failed", action.type)
        self._report(ActionEnded(action.id, ok, text, known))

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
