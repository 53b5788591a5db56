"""Tasks: sent by /exec_task, observed on /robot_status. `TaskTracker` (pure), `TaskMotion`, `TaskHandle`,
`TaskOrder` and `start_task`."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypedDict

from rosproto.codec import DynamicMessage
from rosproto.coercion import whole
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.node import PreparedCall
from rosproto.sentence import Sentence, say
from woosh_pure.components import Components
from woosh_pure.enums import Direction, RobotState, TaskCommand, TaskState, TaskType
from woosh_pure.errors import MotionRefused
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import own_marks, reported_marks, with_marks
from woosh_pure.motion.motion import GoalHandle, Motion
from woosh_pure.motion.progress import PlannedWay
from woosh_pure.outcome import OutcomeKind
from woosh_pure.stopping.stop_executor import Job
from woosh_pure.values.messages import stamped_pose
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
    """Decides whether *this* task has ended, from replies and status messages in any order. Not thread-safe:
    the owner holds a lock.

    Common mistakes of programs, and why they cannot happen here:

    * A stale status 7 of the previous task is taken for an arrival. Only messages with our own (random) task
      id count.
    * The completion comes before the service reply and is lost. The tracker listens before the call is made,
      and a final state is final, whichever comes first.
    * A program waits for ever because the state is 8, 9, negative or a fault. All of these end the task as
      failed, and a task that a fault has only held is cancelled, so that it does not go on unnoticed.
    * A restarted chassis knows nothing of the task. Once ours was seen, a status without any task ends it.
    * Another client's task takes over the robot. Once ours was seen, a running task with another id ends it.

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


logger = get_logger("woosh_pure.task")
_REPLY_SECONDS, _ONCE_MORE = 10.0, 2.0
_MISSED = say("the robot no longer has this task; its end was reported while the connection was down")
_ASKED = {
    TaskType.PICK: "drive to {where}",
    TaskType.PARK: "drive to {where} and park",
    TaskType.CHARGE: "drive to {where} and charge",
    TaskType.CARRY: "drive to {where} and load or unload",
}


class TaskMotion(Motion[RobotStatus]):
    """A task, sent by /exec_task with a random id and observed on /robot_status."""

    def __init__(self, components: Components, order: TaskOrder, tracker: TaskTracker | None = None) -> None:
        tracker = tracker or TaskTracker(new_task_id())
        super().__init__(components, order.sentence(), task_id=tracker.task_id)
        self._order = order
        self._status = components.feeds.get("status")
        self._tracker = tracker
        # The sending thread and the receiving thread update the tracker. No verb holds this lock.
        self._tracker_lock = threading.Lock()
        self._prepared: PreparedCall | None = None
        self._asked_for = False  # whether the chassis may know of it
        self._repeating: Job[None] | None = None
        self._sources: frozenset[str] = frozenset()
        self._off: Callable[[], None] = lambda: None

    @property
    def task_state(self) -> TaskState:
        """Its last known state."""
        return self._tracker.state

    @property
    def drives(self) -> bool:
        return self.task_state not in (TaskState.PAUSED, TaskState.WAITING_FOR_ACTION)

    def begin(self, since: int, *, check: bool, replace: bool) -> None:
        """Send it. It is registered first, so that `stop` in another thread finds it.

        Args:
            since: `ActiveMotions.since` of the verb.
            check: False sends it even beside an open velocity block or another motion of ours.
            replace: True ends any other motion of ours.

        Raises:
            MotionRefused: `stop` was called meanwhile, another motion is under way, or the chassis refused.
            ConnectionLost, RosTimeout, ServiceError: The chassis did not answer.
        """
        motions = self.components.motions
        self._sources, self._off = self._status.sources, self._status.on(self._on_status)
        cancel_job = self.cancel_job()
        start_cancel = partial(motions.executor.put, cancel_job)
        try:
            # The cancel is prepared, on a connection of its own, before the task is sent.
            self._prepared = self.components.clients.prepared_exec_task(TaskCommand.CANCEL, self.task_id)
            self.components.watchdog_client.task(self, self.task_id)
            motions.add_goal(self, since, check=check, replace=replace)
            reply = self.send(self._execute)
        except Exception as error:
            self._note_not_sent(error)
            raise
        except BaseException:  # Ctrl-C: the handle is not returned, so the task must be ended here
            start_cancel()  # must be first: see `stop_executor`
            motions.executor.hold(cancel_job)
            raise
        if not reply.success:
            self._refuse(reply)

    def _execute(self) -> Any:
        if self.asked:
            raise MotionRefused(
                say("{goal}: it was stopped before it was sent; nothing was sent", goal=self.description)
            )
        self._asked_for = True
        reply = self._request()
        with self._tracker_lock:
            self._tracker.reply(reply.success, reply.message, int(reply.statusCode))
        self._settle()
        if self.asked:  # the cancel did not wait long enough for this reply: repeat it
            self.components.clients.exec_task(TaskCommand.CANCEL, self.task_id, timeout=_ONCE_MORE)
        return reply

    def _request(self) -> Any:
        """Ask the robot to begin it; a reply of /exec_task."""
        ask, fields = self.components.clients.exec_task, self._order.fields()
        return ask(TaskCommand.EXECUTE, self.task_id, timeout=_REPLY_SECONDS, **fields)

    def _note_not_sent(self, error: Exception) -> None:
        if self._asked_for and isinstance(error, (ConnectionLost, RosTimeout)):
            # The chassis may have accepted it: cancel it as soon as the chassis can be reached.
            self.ask_end("its request was not answered")
            text = "no reply to the request; it is cancelled as soon as that is possible"
            self.finish(OutcomeKind.CONNECTION_LOST, text)
            self._cancel_once_more()
        else:  # nothing was started, so nothing has to be cancelled
            self._off()
            self.finish(OutcomeKind.CANCELLED, "not sent")
            self._drop_prepared()

    def _refuse(self, reply: DynamicMessage) -> None:
        knowledge, why = self.components.readiness_state, say(reply.message or "no reason given")
        state = RobotState(reply.statusCode)
        refusal = say("the last motion was refused ({what}: {why})", what=self.description, why=why)
        knowledge.refusals.note(refusal, time.monotonic(), state)
        refused = "{goal}: refused by the chassis: {why} (robot state: {state})"
        raise MotionRefused(
            self._with_marks(say(refused, goal=self.description, why=why, state=state)),
            readiness=knowledge.readiness(),
            robot_text=str(reply.message or ""),
        )

    def _with_marks(self, refused: Sentence) -> Sentence:
        """Name the known marks if the task is to another one."""
        mark = self._order.mark
        try:
            parameters = self.components.connection.open_node().params
            known = {**reported_marks(parameters.__getitem__), **own_marks()}
        except (RosError, OSError, ValueError):
            return refused
        return with_marks(refused, known, mark) if mark and known and mark not in known else refused

    def command(self, command: TaskCommand) -> None:
        """Ask for a change of it.

        Raises:
            MotionRefused: The chassis refused.
        """
        reply = self.components.clients.exec_task(command, self.task_id, timeout=_REPLY_SECONDS)
        self._require_yes(reply, command)

    def _require_yes(self, reply: DynamicMessage, command: TaskCommand) -> None:
        if not reply.success:
            raise MotionRefused(
                say(
                    "{goal}: {command} refused: {why}",
                    goal=self.description,
                    command=command,
                    why=say(reply.message or "no reason given"),
                ),
                readiness=self.components.readiness_state.readiness(),
                robot_text=str(reply.message or ""),
            )

    @property
    def in_own_callback(self) -> bool:
        return super().in_own_callback or self._status.in_callback

    def write_cancel(self) -> None:
        if self._prepared is None:
            return  # nothing was sent yet: the sending thread checks `asked`
        if not self._prepared.send():
            raise ConnectionLost("the connection to /exec_task has ended")

    def repeat_cancel(self) -> None:
        if self._repeating is None or self._repeating.over:
            self._repeating = Job(self._cancel_once_more, _ONCE_MORE)
            self.components.motions.executor.put(self._repeating)

    def _cancel_once_more(self) -> None:
        """Cancel again on a new link: the first cancel may have been lost with the old one."""
        try:
            reply = self.components.clients.exec_task(TaskCommand.CANCEL, self.task_id, timeout=_ONCE_MORE)
        except RosError as error:
            logger.debug("! %s: its cancel is repeated in a second: %s", self.description, error)
            return
        if self.may_go_on:
            ended = reply.success or not self._status_shows_it()
        else:  # the status reports how it ended, unless the link was lost at that time
            ended = not reply.success and self._status.outdated
        if ended:
            self._off()
            self.finish(OutcomeKind.CONNECTION_LOST, _MISSED)  # if no outcome was reported yet
            self.see_end()
            self._drop_prepared()

    def request_cancel(self, timeout: float) -> None:
        self.await_sent(min(timeout, 2.0))
        try:
            self._require_yes(self._cancel_reply(timeout), TaskCommand.CANCEL)
        except MotionRefused:
            # "There is no such task": it has just ended, and the status for that may still be on its way.
            if not self.wait(1.0) and not self._status_shows_end():
                raise

    def _cancel_reply(self, timeout: float) -> DynamicMessage:
        """The reply to the prepared cancel, which a stop may have written already. Another connection is
        opened only if that fails: no file may be left for one.
        """
        prepared = self._prepared
        if prepared is not None and prepared.send():
            try:
                answer: DynamicMessage = prepared.answer(min(timeout, 1.0))
                return answer
            except RosError as error:
                logger.debug("! %s: its cancel is sent again: %s", self.description, error)
        return self.components.clients.exec_task(TaskCommand.CANCEL, self.task_id, timeout=timeout)

    def _status_shows_it(self) -> bool:
        """True when the last status shows that it is under way, and no later one can have been missed."""
        status = self._status.latest
        shows = status is not None and status.task_id == self.task_id and not status.task_state.is_final
        return shows and not self._status.outdated

    def _status_shows_end(self) -> bool:
        """True when the last status shows that this task is over."""
        status = self._status.latest
        return status is not None and status.task_id == self.task_id and status.task_state.is_final

    def _on_status(self, status: RobotStatus) -> None:
        with self._tracker_lock:
            self._tracker.status(status)
        if status.task_id == self.task_id:
            self._advance(status)
        self._settle()

    def _settle(self) -> None:
        ending = self._tracker.ending
        if ending is None or self.gone:
            return
        self._off()
        if not ending.under_way:
            self.see_end()  # if an outcome was reported before, such as a lost connection
        self.finish(ending.kind, ending.text, ending.code)
        if ending.under_way:
            self.components.motions.executor.put(Job(self._end_on_robot, _REPLY_SECONDS))
        else:
            self._drop_prepared()

    def _drop_prepared(self) -> None:
        """Close the prepared cancel, which is no longer needed."""
        if self._prepared is not None:
            self._prepared.close()

    def _end_on_robot(self) -> None:
        """Cancel a task that the robot could continue after its fault; in a thread: callbacks call this."""
        try:
            self.components.clients.exec_task(TaskCommand.CANCEL, self.task_id, timeout=_REPLY_SECONDS)
        except RosError as error:
            logger.warning("! %s: not cancelled after the fault, it may go on: %s", self.description, error)
        finally:
            self._drop_prepared()

    def check(self) -> None:
        lost = self.components.feeds.lost("status") or self._restarted()
        if lost and not self.over.is_set:  # keep listening: its end may be reported later
            self.finish(OutcomeKind.CONNECTION_LOST, lost)

    def _restarted(self) -> str:
        """Return a text if another process now reports the state (it does not know this task); else ""."""
        now = self._status.sources
        if not now or not self._sources or now & self._sources:
            return ""
        return say(
            "{topic} comes from another process now: the chassis was restarted, and its task is gone",
            topic=self._status.topic,
        )


class TaskHandle(GoalHandle[RobotStatus]):
    """A task under way; its reports are every status that names it."""

    _motion: TaskMotion

    @property
    def state(self) -> TaskState:
        """Its last known state."""
        return self._motion.task_state

    def pause(self) -> None:
        """Hold it; `resume` goes on.

        Raises:
            MotionRefused: The chassis refused.
        """
        self._motion.command(TaskCommand.PAUSE)

    def resume(self) -> None:
        """Go on after `pause`.

        Raises:
            MotionRefused: The chassis refused, or another motion of ours is under way.
        """
        self._motion.components.motions.require_alone(self._motion)
        self._motion.command(TaskCommand.RESUME)

    def interrupt_wait(self) -> None:
        """End the wait the task is in (task state 5)."""
        self._motion.command(TaskCommand.INTERRUPT_WAIT)


class TaskOptions(TypedDict, total=False):
    """The options of `park`, `charge` and `carry` besides the mark; for their meaning see `Chassis.task`."""

    poses: Sequence[Pose2D]
    type_number: int
    custom: int
    timeout: float | None
    check: bool
    replace: bool


@dataclass(frozen=True, slots=True)
class TaskOrder:
    """The parameters of a task; for the meaning of the fields see `Chassis.task`."""

    task_type: TaskType
    mark: str
    poses: Sequence[Pose2D]
    direction: Direction
    type_number: int
    custom: int

    def sentence(self) -> str:
        """Describe the task."""
        return say(_ASKED[self.task_type], where=self.mark or self.poses[-1])

    def check(self) -> None:
        """Check that the interface can express it.

        Raises:
            ValueError: A number is out of range, or there is no target.
        """
        if self.task_type not in _ASKED:
            raise ValueError(
                say("task type {type}: expected one of {types}", type=self.task_type, types=[*_ASKED])
            )
        if not isinstance(self.mark, str):
            raise ValueError(say("mark {mark!r}: give its name as text, as it is on the map", mark=self.mark))
        if not self.mark and not self.poses:
            raise ValueError("a task needs a mark or poses; give the mark's name as it is on the map")
        if not self.direction.known:
            wrong = "direction {direction}: expected load, unload or undefined"
            raise ValueError(say(wrong, direction=int(self.direction)))
        for name, value, minimum, maximum in (
            ("type_number", self.type_number, 0, 2**32 - 1),
            ("custom", self.custom, -128, 127),
        ):
            number = whole(value)
            if number is None or not minimum <= number <= maximum:
                wrong = "{name}={value!r}: expected a whole number of {minimum} to {maximum}"
                raise ValueError(say(wrong, name=name, value=value, minimum=minimum, maximum=maximum))

    def fields(self) -> dict[str, Any]:
        """The fields of woosh_msgs/ExecTask for this task."""
        return {
            "task_type": int(self.task_type),
            "direction": int(self.direction),
            "task_type_no": int(self.type_number),
            "mark_no": self.mark,
            "poses": [stamped_pose(pose) for pose in self.poses],
            "custom": int(self.custom),
        }


def start_task(
    components: Components, order: TaskOrder, *, timeout: float | None, check: bool, replace: bool
) -> TaskHandle:
    """Subscribe first, then call the service, so that no status is missed."""
    since = components.motions.since
    order.check()
    components.readiness_state.require_ready(order.sentence(), check)
    components.feeds.require_publisher("status")
    motion = TaskMotion(components, order)
    motion.way = PlannedWay(components.feeds)
    handle = TaskHandle(motion, timeout)
    motion.begin(since, check=check, replace=replace)
    return handle
