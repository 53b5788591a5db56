"""Task lists that are stored in the robot: started by the Robot API, observed on /robot_status like tasks.

The tasks of a list follow each other by themselves, each with an id of its own. So a cancel names the task
that runs. One that begins after a cancel is cancelled, too, and so is what the robot begins within some
seconds after its list has failed or was cancelled.
"""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace
from typing import Any

from rosproto.errors import RosError
from rosproto.sentence import Sentence, say
from woosh_pure.components import Components
from woosh_pure.enums import Direction, TaskCommand, TaskState, TaskType
from woosh_pure.errors import ApiRefused
from woosh_pure.motion.task import TaskHandle, TaskMotion, TaskOrder, TaskTracker, logger
from woosh_pure.outcome import OutcomeKind
from woosh_pure.robot_api.api import RobotApi, requests_of
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.robot_api.values import TaskList
from woosh_pure.stopping.stop_executor import Job
from woosh_pure.stopping.watchdog_client import LIST_SECONDS
from woosh_pure.values.state import RobotStatus

_START_SECONDS, _CANCEL_SECONDS = 10.0, 2.0
_ENDS_EARLY = (OutcomeKind.FAILED, OutcomeKind.CANCELLED, OutcomeKind.TIMED_OUT)
_LOOK_SECONDS = 0.2


class ListTracker(TaskTracker):
    """Follows the tasks of a list. The end of one counts after one has run: else it is of an earlier run."""

    def __init__(self, tasks: TaskList) -> None:
        super().__init__(-1)
        self.ids = tasks.tasks

    def status(self, status: RobotStatus) -> None:
        """Take in a status."""
        if status.task_id in self.ids:
            if not (self.seen or status.task_state.is_under_way):
                return
            self.task_id = status.task_id
            if status.task_state is TaskState.COMPLETED and status.task_id != self.ids[-1]:
                return  # the next one follows
        super().status(status)


class _ListOrder(TaskOrder):
    def sentence(self) -> str:
        return say("carry out the task list {name}", name=self.mark)


class TaskListMotion(TaskMotion):
    """A task list under way. Its task id is 0, which stands for the running task, until one has been seen."""

    _tracker: ListTracker

    def __init__(self, components: Components, api: RobotApi, tasks: TaskList) -> None:
        order = _ListOrder(TaskType.UNDEFINED, tasks.name or str(tasks.id), (), Direction.UNDEFINED, 0, 0)
        super().__init__(components, order, ListTracker(tasks))
        self.task_id, self._api, self._tasks = 0, api, tasks

    def _request(self) -> Any:
        status = self._status.latest
        state = 0 if status is None else int(status.robot_state)
        try:
            body = {"taskSetId": self._tasks.id}
            requests_of(self._api).ask(ROBOT + "ExecPreTask", body, timeout=_START_SECONDS)
        except ApiRefused as refused:
            return SimpleNamespace(success=False, message=refused.robot_text, statusCode=state)
        return SimpleNamespace(success=True, message="", statusCode=state)

    def _with_marks(self, refused: Sentence) -> Sentence:
        return refused

    def _on_status(self, status: RobotStatus) -> None:
        begins = status.task_id in self._tracker.ids and status.task_id != self.task_id
        if begins and status.task_state.is_under_way:
            self.task_id = status.task_id
            if self.asked:
                self.components.motions.executor.put(Job(self._cancel_once_more, _CANCEL_SECONDS))
        super()._on_status(status)

    # A cancel goes by both interfaces: the Robot API's order names no task, /exec_task the one seen last.

    def write_cancel(self) -> None:
        self.components.motions.executor.put(Job(self._order_cancel, _CANCEL_SECONDS))
        super().write_cancel()

    def request_cancel(self, timeout: float) -> None:
        self.await_sent(min(timeout, _CANCEL_SECONDS))
        self._order_cancel()
        super().request_cancel(timeout)

    def finish(self, kind: OutcomeKind, *args: Any, **more: Any) -> None:
        """Report the outcome, and watch that nothing follows a list that has not come to its end."""
        first = self.reported is None
        super().finish(kind, *args, **more)
        if first and self._asked_for and kind in _ENDS_EARLY:
            threading.Thread(target=self._end_what_follows, name="woosh:task list", daemon=True).start()

    def _end_what_follows(self) -> None:
        end = time.monotonic() + LIST_SECONDS
        while time.monotonic() < end:
            self._order_cancel()
            time.sleep(_LOOK_SECONDS)

    def _order_cancel(self) -> None:
        """Cancel by the Robot API, if a task of this list is under way."""
        ask = requests_of(self._api).ask
        try:
            task = ask(ROBOT + "TaskProc", timeout=_CANCEL_SECONDS)
            mine = task["robotTaskId"] % 2**64 in self._tasks.tasks
            if mine and TaskState(task["state"]).is_under_way:
                ask(ROBOT + "ActionOrder", {"order": int(TaskCommand.CANCEL)}, timeout=_CANCEL_SECONDS)
        except RosError as error:
            logger.debug("! %s: not cancelled by the Robot API: %s", self.description, error)


def stored_task_list(api: RobotApi, name: str, *, timeout: float = 5.0) -> TaskList:
    """A task list of the robot by its name or id.

    Raises:
        ValueError: The robot has none of that name, or a stop would not end it.
        RosError: The robot has no Robot API, or does not answer.
    """
    lists = api.task_lists(timeout=timeout)
    found = next((each for each in lists if name in (each.name, str(each.id))), None)
    if found is None:
        known = [each.name or str(each.id) for each in lists]
        raise ValueError(say("{name} is not known; expected one of: {known}", name=name, known=known))
    if not found.stoppable or not found.tasks:
        raise ValueError(say("the robot would go on with its task list {name} after a stop", name=name))
    return found


def start_task_list(
    components: Components, api: RobotApi, tasks: TaskList, *, timeout: float | None
) -> TaskHandle:
    """Subscribe first, then ask the robot, so that no status is missed."""
    since = components.motions.since
    motion = TaskListMotion(components, api, tasks)
    handle = TaskHandle(motion, timeout)
    components.readiness_state.require_ready(motion.description, True)
    components.feeds.require_publisher("status")
    motion.begin(since, check=True, replace=False)
    return handle
