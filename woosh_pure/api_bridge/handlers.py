"""`ApiHandlers`: what is sent to the graph, as requests to the robot.

What the robot refuses is refused with its words. Nothing is sent again by itself, zeros and cancels apart.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from functools import partial

from rosproto.action import ServerGoal
from rosproto.codec import DynamicMessage
from rosproto.errors import ConnectionLost, RosError, RosTimeout
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import next_item
from woosh_pure.api_bridge.client import Answer, ApiLink
from woosh_pure.api_bridge.publishing import POSE, STATE, TASK, Publishing
from woosh_pure.enums import RobotState, StepControlMode, TaskCommand, TaskState
from woosh_pure.errors import ApiRefused, ChassisError
from woosh_pure.interface.table import row as interface_row
from woosh_pure.maps.gridmap import GridMap, grid_message
from woosh_pure.maps.mapfiles import cells_of_picture
from woosh_pure.robot_api.commands import COMMANDS, ENDS, STATES, cancel_of, to_api, told
from woosh_pure.robot_api.http import ApiRequests
from woosh_pure.robot_api.translate import ORIGIN, ROBOT, pose_2d, stamped, to_ros
from woosh_pure.robot_api.wire import Values

ORDER, SCENE = ROBOT + "ActionOrder", ROBOT + "Scene"
ANSWER_SECONDS, TASK_SECONDS, UNKNOWN_SECONDS, MAP_SECONDS = 5.0, 8.0, 12.0, 30.0
NO_FEEDBACK_SECONDS = 3.0
MAX_FEEDBACKS = 100  # that wait to be published
_UNDER_WAY = say("another program's task is under way")
_NOT_KNOWN = say("which task is under way is not known")
_log = get_logger("woosh_pure.api_bridge")


class ApiHandlers:
    """The `Handlers` of a bridge, until `closed` is set."""

    def __init__(
        self, link: ApiLink, requests: ApiRequests, publishing: Publishing, closed: threading.Event
    ) -> None:
        self._link, self._requests, self._known, self._closed = link, requests, publishing, closed
        self._lost_tasks: set[int] = (
            set()
        )  # to be cancelled when they show: begun or cancelled without an answer
        self._feedback: dict[str, queue.SimpleQueue[Values]] = {}
        rows = {command.row: interface_row(command.row) for command in COMMANDS}
        self.topics: dict[str, Callable[[DynamicMessage], object]] = {
            name: partial(self._velocity if row.bypasses_protection else self._say, name)
            for name, row in rows.items()
            if row.kind == "topic"
        }
        self.services: dict[str, Callable[[DynamicMessage], dict[str, object]]] = {
            "/exec_task": self._exec_task,
            "/move_base/make_plan": self._make_plan,
            "/aic_map_server/get_map": self._get_map,
            "/woosh_init": self._initialise,
        }
        self.actions = {name: partial(self._act, name) for name, row in rows.items() if row.kind == "action"}
        self.checks = {"/cmd_vel_control": _why_no_step}

    # -- topics ---------------------------------------------------------------------------------------------

    def _velocity(self, topic: str, message: DynamicMessage) -> None:
        _, values = to_api(topic, message)
        if any(values.values()):
            self._link.velocity(values)
        else:
            self._link.zero()

    def _say(self, topic: str, message: DynamicMessage) -> None:
        request, values = to_api(topic, message)
        self._link.post(request, values, partial(_log_refusal, topic))

    # -- tasks ----------------------------------------------------------------------------------------------

    def _exec_task(self, message: DynamicMessage) -> dict[str, object]:
        why = self._change_task(TaskCommand(message.task_exect), message)
        state = self._known.values.get(STATE, {"state": 0})["state"]
        return {"success": not why, "message": why, "statusCode": state}

    def _change_task(self, command: TaskCommand, message: DynamicMessage) -> str:
        """Begin a task or change the one that is under way; return why not, "" if it is done."""
        began, task_id = time.monotonic(), message.task_id
        if command is not TaskCommand.EXECUTE and (why := self._why_not(command, task_id)):
            return why
        self._lost_tasks.discard(task_id)  # one of this number may have been lost before
        try:
            return self._ask("/exec_task", message, TASK_SECONDS)
        except (ConnectionLost, RosTimeout):
            if command in (TaskCommand.EXECUTE, TaskCommand.CANCEL):
                self._lost_tasks.add(task_id)
                self.task_seen()  # it may have come before
            if command is TaskCommand.EXECUTE:  # a reply now would say that it was not accepted
                self._closed.wait(max(0.0, began + UNKNOWN_SECONDS - time.monotonic()))
            raise

    def _ask(self, row: str, message: DynamicMessage, timeout: float = ANSWER_SECONDS) -> str:
        """Send what a message says; return why it is refused, "" if it is not."""
        try:
            self._link.ask(*to_api(row, message), timeout)
        except ApiRefused as refused:
            return refused.robot_text or str(refused)
        except ValueError as error:
            return str(error)
        return ""

    def _why_not(self, command: TaskCommand, task_id: int) -> str:
        """Why the task that is under way is not changed; "" if it may be ours. Does not wait.

        The request names no task. In doubt a cancel is sent: a stop matters more than a stranger's task.
        """
        task = self._known.values.get(TASK)
        if task is None:
            return "" if command is TaskCommand.CANCEL else _NOT_KNOWN
        under_way, same = TaskState(task["state"]).is_under_way, task["robotTaskId"] % 2**64 == task_id
        if under_way and not same and task_id:
            return _UNDER_WAY
        if not under_way and same:
            return say("this task has ended")
        return ""

    def task_seen(self) -> None:
        """Cancel the newest task if its request, or that to cancel it, was not answered."""
        task = self._known.values.get(TASK)
        if task is None or not TaskState(task["state"]).is_under_way:
            return
        task_id = task["robotTaskId"] % 2**64
        if task_id in self._lost_tasks:
            self._lost_tasks.discard(task_id)
            self._link.post(
                ORDER, {"order": int(TaskCommand.CANCEL)}, partial(self._cancel_answered, task_id)
            )

    def _cancel_answered(self, task_id: int, answer: Answer) -> None:
        if isinstance(answer, (ConnectionLost, RosTimeout)):
            self._lost_tasks.add(task_id)  # cancelled when it shows again
        _log_refusal(ORDER, answer)

    # -- other services -------------------------------------------------------------------------------------

    def _make_plan(self, message: DynamicMessage) -> dict[str, object]:
        if not message.start.header.frame_id and (pose := self._pose) is not None:
            message.start = pose
        path = self._link.ask(*to_api("/move_base/make_plan", message))
        return {"plan": to_ros("/move_base/global_plan", {ROBOT + "NavPath": path})}

    @property
    def _pose(self) -> DynamicMessage | None:
        """geometry_msgs/PoseStamped of the robot."""
        found = self._known.values.get(POSE, {}).get("pose")
        return None if found is None else stamped(found)

    def _get_map(self, message: DynamicMessage) -> dict[str, object]:
        # By HTTP: a large answer would delay those that show that the link is good.
        name = self._requests.ask(SCENE)["mapName"]
        maps = self._requests.ask("woosh.map.SceneData", timeout=MAP_SECONDS)["maps"]
        found = next((one for one in maps if one["name"] == name), None)
        if found is None:
            raise ChassisError(say("the robot has no map {name} in its scene", name=name))
        origin = pose_2d(found.get("origin", ORIGIN))
        return {"map": grid_message(GridMap(cells_of_picture(found["mapPng"]), found["resolution"], origin))}

    def _initialise(self, message: DynamicMessage) -> dict[str, object]:
        why = self._ask("/woosh_init", message)
        return {"success": not why, "message": why}

    # -- actions --------------------------------------------------------------------------------------------

    def _act(self, row: str, goal: ServerGoal) -> None:
        """Carry out a goal, until its end was told. A cancel is sent until then, once a second."""
        kind = next(one.type_name for one in COMMANDS if one.row == row)
        inbox = self._feedback[kind] = queue.SimpleQueue[Values]()
        try:
            if why := self._ask_for(row, goal):
                goal.abort(told(row, "Result", goal.goal, done=False), text=why)
            elif row == "/navigation_mode":  # it has no end of its own
                goal.succeed(told(row, "Result", goal.goal, done=True))
            else:
                self._follow(row, goal, inbox)
        finally:
            self._feedback.pop(kind, None)

    def _ask_for(self, row: str, goal: ServerGoal) -> str:
        try:
            return self._ask(row, goal.goal)
        except (ConnectionLost, RosTimeout) as error:
            _log.warning("! %s: %s; it may have begun", row, error)
            return ""

    def _follow(self, row: str, goal: ServerGoal, inbox: queue.SimpleQueue[Values]) -> None:
        heard, cancel_at = time.monotonic(), 0.0
        while not goal.status.is_terminal:  # the bridge is closed
            now = time.monotonic()
            if goal.cancel_requested and self._link.up and now >= cancel_at:
                cancel_at = now + 1.0
                self._link.post(*cancel_of(row))
            try:
                feedback = next_item(inbox, 0.05)
            except queue.Empty:
                if not self._link.up or not self._idle:
                    heard = now
                elif now - heard > NO_FEEDBACK_SECONDS:
                    text = say("the robot is idle and has told no end: whether it was done is not known")
                    goal.abort(told(row, "Result", goal.goal, done=False), text=text)
                    return
                continue
            heard = now
            state, code = feedback["state"], feedback["code"]
            if state in ENDS:
                result = told(row, "Result", goal.goal, done=state == STATES["kRosSuccess"])
                if state == STATES["kRosSuccess"]:
                    goal.succeed(result)
                elif state == STATES["kRosCancel"]:
                    goal.preempted(result, text="preempted")
                else:
                    goal.abort(result, text=feedback["msg"] or f"status code {code}")
                return
            report = told(row, "Feedback", goal.goal, done=False)
            if hasattr(report, "base_position") and (pose := self._pose) is not None:
                report.base_position = pose
            goal.publish_feedback(report)

    def cancel(self, row: str, goal: DynamicMessage) -> None:
        """A cancel has come; that of all goals means other clients' goals as well, which no list here has."""
        if not goal.id and not goal.stamp.to_sec():
            self._link.post(*cancel_of(row))

    def feedbacks(self, values: Values) -> None:
        """Feedbacks have come; of a kind that nothing of ours has begun they are another client's."""
        for feedback in values["fbs"]:
            inbox = self._feedback.get(feedback["action"])
            if inbox is not None and (inbox.qsize() < MAX_FEEDBACKS or feedback["state"] in ENDS):
                inbox.put(feedback)

    @property
    def _idle(self) -> bool:
        state = RobotState(self._known.values.get(STATE, {"state": 0})["state"])
        return (
            state in (RobotState.IDLE, RobotState.CHARGING, RobotState.UNINITIALISED) and self._known.stands
        )


def _why_no_step(goal: DynamicMessage) -> str | None:
    if goal.mode in (StepControlMode.PAUSE, StepControlMode.RESUME):
        return say("the Robot API does not tell how far a paused step has come, so what remains is not known")
    return None


def _log_refusal(what: str, answer: Answer) -> None:
    if isinstance(answer, RosError):
        _log.error("! %s: %s", what, answer)
