"""`Commands`: what clients of the server ask the robot to do, with the guards of all doors.

A velocity goes through `ClientPublications` and the velocity watchdog, which sends zero after a client that
is silent or gone. Stops (a zero, a cancel, the pause of a task) need no lease, ask for no state, and wait for
no other command.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Hashable
from functools import partial
from typing import TYPE_CHECKING, Any

from rosproto.action import ActionClient, GoalHandle, GoalStatus
from rosproto.errors import RosError
from rosproto.gateway import Refused
from woosh_pure.connection.firmware_limits import require_goal, require_message
from woosh_pure.connection.other_drivers import other_drivers
from woosh_pure.enums import RobotMode, RobotState, StepControlMode, TaskCommand, TaskState
from woosh_pure.faults import with_words
from woosh_pure.geometry import Velocity
from woosh_pure.interface.table import row as interface_row
from woosh_pure.lease import ChassisLease
from woosh_pure.motion.steps import check_goal
from woosh_pure.robot_api.commands import CALL, FEEDBACKS, STATES, member_of, row_of, to_ros
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.robot_api.wire import Values
from woosh_pure.values.messages import service_type

if TYPE_CHECKING:
    from woosh_pure.api_server.state import ApiState

TWIST, TASK, ORDER = ROBOT + "Twist", ROBOT + "ExecTask", ROBOT + "ActionOrder"
MOVING = ("Twist", "ExecTask", "ExecPreTask", "ActionOrder", "CallAction")
LEASE_SECONDS = 5.0
CALL_SECONDS = 5.0
LATE_SECONDS = 1.0
HEARD_SECONDS = 1.0  # as `chassis.velocity` ends when the robot falls silent
DRIVES_SECONDS = 0.5
"""For which a client drives after its last velocity: zero follows then."""
IDLE_SECONDS = 2.0
"""Without velocities, after which their topic is left: others take its publisher for a driver."""


class Commands:
    """Carries out the commands of all clients of one server; `lease` and `share` as of `RobotApiServer`."""

    def __init__(self, state: ApiState, lease: ChassisLease | None, share: bool) -> None:
        self._state, self._lease, self._share = state, lease, share
        self._lock, self._opening = threading.Lock(), threading.Lock()
        self._output: Any = None  # the `ClientPublication` of velocities
        self._sent = 0.0  # when the last velocity was
        self._driving: dict[Hashable, float] = {}  # when the last one of each client that drives came
        self._actions: dict[str, ActionClient] = {}
        self._goals: dict[str, GoalHandle | None] = {}  # under way, by kind
        self._task_id = 0  # of the last task from here
        self._cancelled = -math.inf  # when the newest cancel came
        self._closing = threading.Event()
        self._handlers: dict[str, Callable[[Hashable, str, Values, float], Values | None]] = {
            TWIST: self._velocity,
            TASK: self._task,
            ROBOT + "ExecPreTask": self._task_list,
            ORDER: self._order,
            CALL: self._act,
            ROBOT + "InitRobot": self._initialise,
            **{ROBOT + name: self._publish for name in ("SetRobotPose", "Speak", "LED")},
            **{ROBOT + name: self._keep for name in ("SwitchMap", "SwitchControlMode", "SwitchWorkMode")},
        }

    def waits(self, type_name: str, client: Hashable) -> bool:
        """Whether a command of a client may take long. The velocities of one that drives do not."""
        driving = time.monotonic() - self._driving.get(client, -math.inf) < DRIVES_SECONDS
        return type_name != TWIST or not driving or self._output is None

    def do(self, client: Hashable, type_name: str, values: Values, received: float) -> Values:
        """Carry out what a client asked for at `received`, by `time.monotonic()`; return the answer's values.

        What was accepted may go on for long.

        Raises:
            Refused, RosError, ValueError: Why not.
        """
        handler = self._handlers.get(type_name)
        if handler is None:
            raise Refused(f"{type_name} is refused: this server does not do it, and nothing was done")
        kind, inner = member_of(type_name, values)
        allowed = self._state.access.may_write
        refusal = allowed("api", type_name.rpartition(".")[2])
        # Where all that moves the robot is closed, no client can have moved it.
        if _stops(kind, inner) and (refusal is None or not all(allowed("api", each) for each in MOVING)):
            return handler(client, kind, inner, received) or {}
        if refusal is not None:
            raise Refused(refusal.text)
        if self._lease is not None and not self._lease.acquire(f"robot-api {client}", LEASE_SECONDS):
            raise Refused(f"{self._lease.holder} has the lease of this robot: ask there, or wait")
        with self._state.waiting():
            return handler(client, kind, inner, received) or {}

    def gone(self, client: Hashable) -> None:
        """A client has left: zero follows if it drove; its goals and tasks go on."""
        self._state.velocity_watchdog.gone(client)
        self._driving.pop(client, None)

    def close(self) -> None:
        """The server ends: goals and tasks go on."""
        self._closing.set()
        for client in list(self._actions.values()):
            client.close()

    # -- velocities -----------------------------------------------------------------------------------------

    def _velocity(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        row, message = to_ros(kind, values)
        moving = not _stops(kind, values)
        if moving:
            self._require_may_drive(client, Velocity(message.linear.x, message.linear.y, message.angular.z))
        while True:
            output = self._output or self._open(row, type(message))
            with self._lock:
                if moving and time.monotonic() - received > LATE_SECONDS:
                    raise Refused("the velocity waited for too long, so it is not obeyed any more")
                if output is self._output:
                    if moving:
                        self._require_alone(client)  # another one may have begun since it was asked
                    output.publish(message, received, client)
                    self._sent = time.monotonic()
                    if moving:
                        self._driving[client] = self._sent
                    else:
                        self._driving.pop(client, None)
                    return

    def _require_may_drive(self, client: Hashable, velocity: Velocity) -> None:
        if not self._state.hears("/odom_twist", HEARD_SECONDS):
            raise Refused("the robot is not heard (/odom_twist), so it is not driven")
        state, mode, task = (self._state.known(ROBOT + name) for name in ("RobotState", "Mode", "TaskProc"))
        if mode and mode["ctrl"] != RobotMode.AUTOMATIC:
            raise Refused("the robot is not in automatic mode, so it is not driven")
        idle = not state or state["state"] in (RobotState.UNINITIALISED, RobotState.IDLE)
        if (task and TaskState(task["state"]).is_under_way) or not idle:
            raise Refused("the robot is not idle or has a task, so it is not driven")
        if self._goals:
            raise Refused(f"an action is under way ({next(iter(self._goals))}), so it is not driven")
        self._state.drive_limits().check(velocity)
        self._require_alone(client)
        if self.waits(TWIST, client) and not self._share:
            for driver in other_drivers(self._state.node):
                if not driver.on_robot:
                    raise Refused(f"{driver.sentence()}; the robot would obey both in turn: end that program")

    def _require_alone(self, client: Hashable) -> None:
        now = time.monotonic()
        for other, last in [] if self._share else list(self._driving.items()):
            if other != client and now - last < DRIVES_SECONDS:
                raise Refused(f"another client drives the robot: {other}")

    def _open(self, row: str, kind: type[Any]) -> Any:
        with self._opening:
            output = self._output  # `_leave` may end it meanwhile
            if output is None:
                self._sent = time.monotonic()
                output = self._output = self._state.publications.open(self, row, kind)
                self._state.pool.spawn(self._leave)
            return output

    def _leave(self) -> None:
        """Leave the topic of velocities when nobody has used it for some seconds."""
        while not self._closing.wait(0.5):
            with self._lock:
                if time.monotonic() - self._sent < IDLE_SECONDS:
                    continue
                output, self._output = self._output, None
                self._driving.clear()
            output.close()
            return

    # -- tasks ----------------------------------------------------------------------------------------------

    def _task(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        row, request = to_ros(kind, values)
        self._require_alone(client)
        self._require_wanted(received)
        self._task_id = request.task_id
        try:
            reply = self._call(row, request)
        finally:  # without a reply the robot may have accepted it
            if self._cancelled > received:  # by another request, meanwhile
                self._order(client, ORDER, {"order": TaskCommand.CANCEL}, received)
        _require(reply)
        self._require_wanted(received)

    def _task_list(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        """Begin a task list that is stored in the robot; a cancel is then for whatever task runs."""
        self._require_alone(client)
        self._require_wanted(received)
        self._task_id = 0
        self._state.start_list(values["taskSetId"])
        if self._cancelled > received:  # by another request, meanwhile
            self._order(client, ORDER, {"order": TaskCommand.CANCEL}, received)

    def _order(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        """An order for the task under way; a cancel also for the last one from here, which the robot may not
        have told yet."""
        row, request = to_ros(kind, values)
        cancels = request.task_exect == TaskCommand.CANCEL
        self._cancelled = max(self._cancelled, received) if cancels else self._cancelled
        task = self._state.known(ROBOT + "TaskProc")
        ids = [task["robotTaskId"]] if task is not None and TaskState(task["state"]).is_under_way else []
        for request.task_id in dict.fromkeys((*ids, self._task_id)):
            reply = self._call(row, request)
            if reply.success or not cancels:
                break
        _require(reply)

    def _require_wanted(self, received: float) -> None:
        if self._cancelled > received:
            raise Refused("it was cancelled by another request meanwhile")

    def _call(self, row: str, request: Any) -> Any:
        with self._state.node.service_client(row, service_type(interface_row(row).type)) as client:
            client.lossless = True
            return client.call(request, CALL_SECONDS)

    # -- actions --------------------------------------------------------------------------------------------

    def _act(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        mode = values.get("action", StepControlMode.EXECUTE)
        if mode == StepControlMode.CANCEL:
            self._cancelled = max(self._cancelled, received)
            self._action(row_of(kind)).cancel_all()
            return
        if mode != StepControlMode.EXECUTE:
            raise Refused("this server neither pauses nor resumes an action: cancel it, and send the rest")
        row, goal = to_ros(kind, values)
        if hasattr(goal, "stepControl"):
            check_goal(goal)
        self._require_alone(client)
        server = self._action(row)
        require_goal(server, goal)
        with self._lock:
            if kind in self._goals:
                raise Refused("one of this kind is under way: cancel it first (action 0)")
            self._goals[kind] = None
        try:
            self._require_wanted(received)
            sent = self._goals[kind] = server.send_goal(goal)
            if self._cancelled > received:
                sent.cancel()
        except BaseException:
            self._goals.pop(kind, None)
            raise
        self._tell(kind, "Executing")
        self._state.pool.spawn(partial(self._follow, kind, sent))

    def _action(self, row: str) -> ActionClient:
        """The client of an action, kept until the node closes."""
        found = self._actions.get(row)
        if found is None:
            with self._opening:
                found = self._actions.get(row) or ActionClient(self._state.node, row, interface_row(row).type)
                self._actions[row] = found
        found.wait_for_server(CALL_SECONDS)
        return found

    def _follow(self, kind: str, goal: GoalHandle) -> None:
        """Push the end of a goal; runs in its own thread."""
        end, text = "Failure", ""
        try:
            result, text = goal.wait(None), with_words(goal.text)
            if goal.status in (GoalStatus.PREEMPTED, GoalStatus.RECALLED):
                end = "Cancel"
            elif goal.status is GoalStatus.SUCCEEDED and getattr(result, "result", 1) > 0:
                end = "Success"
        except RosError as error:
            text = str(error)
        finally:
            self._goals.pop(kind, None)
            self._tell(kind, end, text)

    def _tell(self, kind: str, state: str, text: str = "") -> None:
        told = {"action": kind, "state": STATES[f"kRos{state}"], "msg": text}
        self._state.push_event(FEEDBACKS, {"fbs": [told]})

    # -- poses, voice, light, map and mode -------------------------------------------------------------------

    def _publish(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        row, message = to_ros(kind, values)
        with self._state.node.publisher(row, type(message), queue_size=1) as publisher:
            publisher.wait_for_connection(CALL_SECONDS)
            require_message(row, publisher, message)
            publisher.publish(message)
            publisher.close(wait=CALL_SECONDS)

    def _initialise(self, client: Hashable, kind: str, values: Values, received: float) -> None:
        if "pose" in values:
            self._publish(client, ROBOT + "SetRobotPose", values, received)
        _require(self._call(*to_ros(kind, values)))

    def _keep(self, client: Hashable, kind: str, values: Values, received: float) -> Values:
        """Accept the map or the mode that is in use: programs ask for it before they begin."""
        scene, mode = (self._state.answer(ROBOT + name, {}) for name in ("Scene", "Mode"))
        if "mode" in values:
            same = values["mode"] == mode["ctrl" if kind.endswith("ControlMode") else "work"]
        else:
            same = values["sceneName"] == scene["sceneName"]
            same = same and values["mapName"] in ("", scene["mapName"]) and not values["fileDatas"]
        if not same:
            raise Refused("this server changes neither the map nor the mode in use")
        return mode if "mode" in values else {}


def _stops(kind: str, values: Values) -> bool:
    """Whether a command only ends or holds a motion."""
    if kind == TWIST:
        return not any(values[name] for name in ("linear", "linearY", "angular"))
    if kind == ORDER:
        return values["order"] in (TaskCommand.CANCEL, TaskCommand.PAUSE)
    return bool(values.get("action", StepControlMode.EXECUTE) == StepControlMode.CANCEL)


def _require(reply: Any) -> None:
    if not reply.success:
        raise Refused(reply.message or "the robot refused it without a reason")
