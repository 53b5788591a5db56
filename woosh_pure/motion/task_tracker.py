"""Decides whether *this* task has ended, from replies and status messages in any order. Pure.

Common mistakes of programs, and why they cannot happen here:

* A stale status 7 of the previous task is taken for an arrival. Only messages with our own (random) task id
  count.
* The completion comes before the service reply and is lost. The tracker listens before the call is made, and
  a final state is final, whichever comes first.
* A program waits for ever because the state is 8, 9, negative or a fault. All of these end the task as
  failed, and a task that a fault has only held is cancelled, so that it does not go on unnoticed.
* A restarted chassis knows nothing of the task. Once ours was seen, a status without any task ends it.
* Another client's task takes over the robot. Once ours was seen, a running task with another id ends it.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

from rosproto.sentence import say
from woosh_pure.enums import RobotState, TaskState
from woosh_pure.outcome import OutcomeKind
from woosh_pure.values.state import RobotStatus

_ENDS = {
    TaskState.COMPLETED: OutcomeKind.ARRIVED,
    TaskState.CANCELLED: OutcomeKind.CANCELLED,
    TaskState.FAILED: OutcomeKind.FAILED,
}


def new_task_id() -> int:
    """A task id that no other client and no earlier task has; 31 bits fit into every integer field."""
    return random.SystemRandom().randrange(1 << 20, 1 << 31)


@dataclass(frozen=True, slots=True)
class TaskEnd:
    """How the task ended, as the chassis reported it.

    Attributes:
        kind, code, text: As in `Outcome`.
        under_way: True when the task has not ended on the chassis: unless it is cancelled there, it may go on
            when the robot has recovered.
    """

    kind: OutcomeKind
    code: int | None
    text: str
    under_way: bool = False


class TaskTracker:
    """State of one task. Not thread-safe: the owner holds a lock.

    Attributes:
        task_id: The id of our task.
        accepted: What the service replied; None before the reply, and when it was lost.
        seen: Whether a status has named our task.
        state: The task's last known state.
        ending: Set once, None until the task has ended.
    """

    def __init__(self, task_id: int) -> None:
        self.task_id = task_id
        self.accepted: bool | None = None
        self.seen = False
        self.state = TaskState.UNDEFINED
        self.ending: TaskEnd | None = None

    def reply(self, success: bool, message: str, code: int) -> None:
        """Take in the reply of the service."""
        self.accepted = success
        if not success:
            # A refusal overrides an earlier status: nothing was started for us.
            self.ending = TaskEnd(OutcomeKind.REJECTED, code, message or "the chassis refused the task")

    def status(self, status: RobotStatus) -> None:
        """Take in a status."""
        if self.ending is not None:
            return
        if status.task_id == self.task_id:
            self._own(status)
        elif self.seen and status.task_state.is_under_way:
            text = say("task {id} took over", id=status.task_id)
            self.ending = TaskEnd(OutcomeKind.REPLACED, int(status.task_state), text)
        elif self.seen and status.task_id == 0 and status.task_state is TaskState.UNDEFINED:
            self.ending = TaskEnd(
                OutcomeKind.FAILED, 0, "the chassis no longer has a task; was it restarted?"
            )

    def _own(self, status: RobotStatus) -> None:
        self.seen = True
        self.state = status.task_state
        kind = _ENDS.get(status.task_state)
        if kind is not None:
            self._end(kind, status)
        elif int(status.task_state) < 0:
            reason = say("the chassis reports task state {state}", state=int(status.task_state))
            self._end(OutcomeKind.FAILED, status, reason)
        elif status.robot_state is RobotState.FAULT:
            text = status.message or "the robot is in fault"
            self.ending = TaskEnd(OutcomeKind.FAILED, int(status.robot_state), text, under_way=True)

    def _end(self, kind: OutcomeKind, status: RobotStatus, text: str = "") -> None:
        self.ending = TaskEnd(kind, int(status.task_state), status.message or text)
