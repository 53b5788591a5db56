"""`TaskMachine`: the tasks of /exec_task and their states in /robot_status. Pure: the world steps it.

States and their numbers are the vendor's (see `woosh_pure.enums`). Undocumented behaviour is marked
"assumed".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from woosh_pure.enums import (
    ActionState,
    ActionType,
    TaskCommand,
    TaskState,
    TaskType,
    WorkMode,
)
from woosh_pure.geometry import Pose2D
from woosh_pure.sim.motions import Motion, MotionState

if TYPE_CHECKING:
    from woosh_pure.sim.world import World


@dataclass(frozen=True, slots=True)
class TaskRequest:
    """An ExecTask request; poses are in the map, None if one cannot be converted."""

    command: TaskCommand
    task_id: int
    task_type: TaskType = TaskType.PICK
    mark: str = ""
    poses: Sequence[Pose2D] | None = ()


@dataclass(frozen=True, slots=True)
class TaskReply:
    """An ExecTask response; `code` is the robot state."""

    success: bool
    message: str
    code: int


_REFUSALS = {
    110201000013: "emergency stop",
    110202000013: "bumper",
    140801000081: "not in automatic mode",
    140801000121: "not in task mode",
    140201000022: "not localised",
    140801000261: "charging cable plugged in",
    140801000111: "another task is running",
}


class TaskMachine:
    """One task at a time; a finished task stays visible until the next one starts.

    Attributes:
        drive: Starts a drive: `(way, keep_path) -> Motion`. The ROS side sends a goal to /move_base, as
            /ros_interface does; by default the world is called directly.
    """

    AT_MARK = 0.5
    """Largest distance between the end of a given path and its mark, m (the value is assumed)."""
    CARRY_SECONDS = 2.0
    CHARGE_SECONDS = 1.0

    def __init__(self, world: World) -> None:
        self._world = world
        self.drive: Callable[[Sequence[Pose2D], bool], Motion] = self._drive_directly
        self.power_up()

    def power_up(self) -> None:
        """Forget all tasks."""
        self._motion: Motion | None = None
        self._handling: float | None = None  # seconds until what is done at the target has ended
        self.task_id = 0
        self.task_type = TaskType.UNDEFINED
        self.state = TaskState.UNDEFINED
        self.action_type = ActionType.UNDEFINED
        self.action_state = ActionState.UNDEFINED
        self.wait_id = 0
        self.dest = ""
        self.message = ""
        self.fail_next: str | None = None
        self._following: list[TaskRequest] = []  # of a task list

    @property
    def busy(self) -> bool:
        """True while a task is under way, paused or waiting."""
        return self.state.is_under_way

    def request(self, request: TaskRequest) -> TaskReply:
        """Answer a call of /exec_task."""
        handlers = {
            TaskCommand.EXECUTE: self._execute,
            TaskCommand.PAUSE: self._pause,
            TaskCommand.RESUME: self._resume,
            TaskCommand.CANCEL: self._cancel,
            TaskCommand.INTERRUPT_WAIT: self._interrupt_wait,
        }
        handler = handlers.get(request.command)
        if handler is None:
            return self._reply(False, f"task_exect {int(request.command)} is not known")
        return handler(request)

    def start_list(self, tasks: Sequence[TaskRequest]) -> str:
        """Begin tasks that follow each other; why not, "" if they do. A failure or cancel ends them."""
        reply = self._execute(tasks[0])
        if reply.success:
            self._following = [*tasks[1:]]
        return "" if reply.success else reply.message

    def _reply(self, success: bool, message: str, code: int = 0) -> TaskReply:
        if code:
            self._world.report(code)
        return TaskReply(success, message, int(self._world.robot_state))

    def _execute(self, request: TaskRequest) -> TaskReply:
        refusal = self._refusal()
        if refusal:
            return self._reply(False, _REFUSALS[refusal], refusal)
        if request.poses is None:
            return self._reply(False, "a pose is not finite or in an unknown frame", 140801000141)
        mark = self._world.site.marks.get(request.mark)
        target = list(request.poses) or ([] if mark is None else [mark.pose])
        if not target or (request.mark and mark is None):
            return self._reply(False, "this mark is not known", 140801000141)
        if mark is not None and target[-1].distance_to(mark.pose) > self.AT_MARK:
            return self._reply(False, f"the path does not end at mark {request.mark!r}", 140801000151)
        self._begin(request, target)
        return self._reply(True, "ok")

    def _refusal(self) -> int:
        """The code of why no task starts now; 0 if one may."""
        code = self._world.cannot_move()
        if not code and self._world.work_mode is not WorkMode.TASK:
            code = 140801000121
        if not code and self.busy:
            code = 140801000111
        return code

    def _begin(self, request: TaskRequest, target: list[Pose2D]) -> None:
        self.task_id = request.task_id
        self.task_type = request.task_type
        self.dest = request.mark
        self.message = ""
        self.wait_id = 0
        self._set(TaskState.RUNNING, ActionType.NAVIGATION, ActionState.RUNNING)
        self._world.leave_dock()
        self._motion = self.drive(target, len(target) > 1)

    def _drive_directly(self, way: Sequence[Pose2D], keep_path: bool) -> Motion:
        return self._world.navigate("task", way, keep_path=keep_path)

    def _pause(self, request: TaskRequest) -> TaskReply:
        if self.state is not TaskState.RUNNING:
            return self._reply(False, "no running task to pause", 140801000271)
        if self._motion and self._motion.state is MotionState.RUNNING:
            self._motion.pause()
        self._set(TaskState.PAUSED, self.action_type, ActionState.PAUSED)
        return self._reply(True, "ok")

    def _resume(self, request: TaskRequest) -> TaskReply:
        if self.state is not TaskState.PAUSED:
            return self._reply(False, "no paused task to resume", 140801000281)
        if self._motion and self._motion.state is MotionState.PAUSED:
            self._motion.resume()
        self._set(TaskState.RUNNING, self.action_type, ActionState.RUNNING)
        return self._reply(True, "ok")

    def _cancel(self, request: TaskRequest) -> TaskReply:
        if not self.busy:
            return self._reply(False, "no task to cancel")
        if request.task_id not in (0, self.task_id):
            return self._reply(False, f"task {request.task_id} is not the running one ({self.task_id})")
        self._finish(TaskState.CANCELLED, ActionState.CANCELLED, "cancelled")
        return self._reply(True, "ok")

    def _interrupt_wait(self, request: TaskRequest) -> TaskReply:
        if self.state is not TaskState.WAITING_FOR_ACTION:
            return self._reply(False, "no wait to interrupt", 140801000291)
        self._complete()
        return self._reply(True, "ok")

    def _set(self, state: TaskState, action: ActionType, action_state: ActionState) -> None:
        self.state, self.action_type, self.action_state = state, action, action_state

    def _finish(self, state: TaskState, action_state: ActionState, message: str) -> None:
        if self._motion:
            self._world.end_motion(self._motion, MotionState.CANCELLED)
        self._motion = None
        self._handling = None
        self.message = message
        if state is not TaskState.COMPLETED:
            self._following = []
        self._set(state, self.action_type, action_state)

    def _complete(self) -> None:
        self._finish(TaskState.COMPLETED, ActionState.DONE, "")

    def fail(self, message: str) -> None:
        """Fail the running task."""
        if self.busy:
            self._finish(TaskState.FAILED, ActionState.FAILED, message)

    def step(self, dt: float) -> None:
        """Advance the task; called after the base has moved."""
        if self._following and not self.busy and not self._execute(self._following.pop(0)).success:
            self._following = []
        if self.state is not TaskState.RUNNING:
            return
        if self.fail_next is not None:
            message, self.fail_next = self.fail_next, None
            self.fail(message)
            return
        if self._handling is not None:
            self._handling -= dt
            if self._handling <= 0.0:
                self._complete()
        elif self._motion and self._motion.state.is_final:
            self._navigation_ended(self._motion)

    def _navigation_ended(self, motion: Motion) -> None:
        if motion.state is not MotionState.DONE:
            reason = (
                "replaced by another command" if motion.state is MotionState.REPLACED else "navigation failed"
            )
            self.fail(reason)
            return
        mark = self._world.site.marks.get(self.dest)
        if self.task_type is TaskType.CHARGE and mark is not None and mark.charger:
            self._world.enter_dock()
            self._start_handling(ActionType.CHARGE, self.CHARGE_SECONDS)
        elif self.task_type is TaskType.CHARGE:
            self.fail("no charger at the target")
        elif self.task_type is TaskType.CARRY:
            self._start_handling(ActionType.CARRY_ACTION, self.CARRY_SECONDS)
        elif mark is not None and mark.waits:
            self.wait_id += 1
            self._set(TaskState.WAITING_FOR_ACTION, ActionType.WAIT, ActionState.RUNNING)
        else:
            self._complete()

    def _start_handling(self, action: ActionType, seconds: float) -> None:
        self._handling = seconds
        self._set(TaskState.RUNNING, action, ActionState.RUNNING)
