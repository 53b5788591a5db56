"""`Chassis`: the main API. Reading needs no permission; moving is an explicit call."""

from __future__ import annotations

import inspect
import math
import os
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.coercion import as_float
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.logs import get_logger
from rosproto.msg import learned_paths
from rosproto.profile import remembered
from rosproto.sentence import led, say
from rosproto.transport import Deadline, HostNames, is_loopback, parse_uri
from rosproto.watchdog import Watchdog
from woosh_pure import interface
from woosh_pure.components import Components
from woosh_pure.connection.arguments import MAX_TIMEOUT_SECONDS, master_uri_of, require_timeout
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.connection.connection import Connection
from woosh_pure.connection.velocity_topics import VELOCITY_TOPICS
from woosh_pure.errors import MotionRefused
from woosh_pure.hints import CHASSIS, SettingHints, usage
from woosh_pure.lease import ChassisLease
from woosh_pure.motion.action_goal import ActionHandle, start_action
from woosh_pure.motion.steps import MAX_SPEED, MAX_TURN_RATE
from woosh_pure.motion.verbs import MotionVerbs
from woosh_pure.peripherals import Peripherals
from woosh_pure.readings import Readings
from woosh_pure.reasons import Readiness
from woosh_pure.robot_api.background import Background
from woosh_pure.robot_api.http import ApiAddress, only_robot_api
from woosh_pure.stopping.report import StopReport
from woosh_pure.stopping.stop import stop as _stop
from woosh_pure.stopping.stop import stop_seconds
from woosh_pure.values.messages import require_finite
from woosh_pure.velocity.drive import Drive
from woosh_pure.velocity.shaper import DEFAULT_ANGULAR, DEFAULT_LINEAR, DriveLimits

if TYPE_CHECKING:
    from woosh_pure import aio, values
    from woosh_pure.api_bridge.bridge import ApiBridge
    from woosh_pure.missions import Missions
    from woosh_pure.motion.task import TaskHandle
    from woosh_pure.robot_api.api import RobotApi
    from woosh_pure.robot_api.values import TaskList

__all__ = ["Chassis", "components_of"]

_log = get_logger("woosh_pure.chassis")

# Seconds for which nothing must block: messages of different topics may come in another order than sent.
_SETTLED = 0.3
# Time limits of steps that Ctrl-C does not end; longer than the limits of their parts.
_CLOSED = "this Chassis is closed"
_NO_WATCHDOG = (
    "{uri}: if this program is killed, the robot must end a velocity by itself, and tasks and goals go on; "
    "watchdog=True ends them"
)
_CLOSE_SECONDS, _LEAVE_SECONDS = 30.0, 10.0
_CANCEL_SECONDS, _LATE_SECONDS = 3.0, 1.0  # for `close` to cancel goals; for goals that it finds afterwards


class Chassis(Readings, MotionVerbs, Peripherals, SettingHints):
    """One chassis. Use it in a `with` block: leaving it cancels what this program started and still runs.

    Nothing happens on the network before the first verb or feed is used. The node's name is made unique, so
    several programs and several robots live side by side. Methods may be called from any thread.

    Reading: `battery`, `pose`, `scan`, `status` ... are feeds; `readiness`, `faults`, `snapshot`.
    Moving: `go_to_mark`, `park`, `charge`, `carry`, `task`, `task_list`; `go_to`, `follow`; `move`, `rotate`,
    `strafe`, `steps`; `action` for lifts and docks. Each returns a handle; `handle.wait()` raises unless it
    arrived.
    Driving by velocity: `with chassis.velocity(bypasses_protection=True) as drive:`.
    Stopping: `stop`, from anywhere. It is not an emergency stop.
    All else: `set_pose`, `get_map`, `plan`, `set_footprint`, `set_navigation_mode`, `light`, `say` ...

    Args:
        address: "169.254.128.2", "host:port" or a master URI; None takes $ROS_MASTER_URI, else the robot that
            `woosh connect` has saved. "ws://host:5480" is a robot that has only the Robot API (extra `api`).
        name: Prefix of our node's name.
        host: Our own address as the robot reaches it; None finds it from the route to the master.
        timeout: Default time limit for connecting and for services, s.
        leave_running: True leaves goals running at the end of the `with` block (velocity blocks end always).
        msg_path: Folders with .msg, .srv and .action files: further revisions, for a robot that has those,
            and the types of `node`. Verbs and feeds keep their definitions.
        learned: Use also what `woosh learn` has kept for this user.
        resolve: Host name -> address, for names of the robot that this computer does not know. A name that is
            not given and cannot be resolved is replaced by the master's host; this is logged.
        watchdog: True starts a small process (20 MB) that sends zero and cancels the motions of this object
            when the program is killed, or does not run for 0.8 s; with `leave_running` goals continue. A
            `rosproto.watchdog.Watchdog` can be shared by several. It is not an emergency stop.
        robot_api: Where its Robot API is: None for port 5480 of the same host, tried when it is asked for;
            "host:port" or "user:password@host:port"; False for never.
        missions_state: Folder in which `chassis.missions` keeps its queue and runs; None for the user's.

    Raises:
        ValueError: There is no address, or `address`, `timeout`, `resolve` or `robot_api` is invalid.
        DefinitionError: A folder of `msg_path` does not exist or has no definition.
    """

    _hints = CHASSIS

    @usage('Chassis("192.168.1.20"), or Chassis("192.168.1.20:11311") with the port of its master')
    def __init__(
        self,
        address: str | None = None,
        *,
        name: str = "woosh_pure",
        host: str | None = None,
        timeout: float = 5.0,
        leave_running: bool = False,
        msg_path: Iterable[str | os.PathLike[str]] = (),
        learned: bool = True,
        resolve: Mapping[str, str] | None = None,
        watchdog: bool | Watchdog = False,
        robot_api: str | bool | None = None,
        missions_state: str | os.PathLike[str] | None = None,
    ) -> None:
        if address is None and (profile := remembered()) is not None:
            address, host = profile.chassis, host or profile.host
        self.master_uri = master_uri_of(address)
        timeout = as_float(timeout)
        self._aio: aio.Chassis | None = None
        self._lease = ChassisLease()
        if not 0.0 < timeout < math.inf:
            raise ValueError(
                say("timeout={timeout}: expected more than 0 s, and not for ever", timeout=timeout)
            )
        timeout = min(timeout, MAX_TIMEOUT_SECONDS)
        folders = [*msg_path, *(learned_paths() if learned else ())]
        names = HostNames(resolve).given
        self._robot_api: RobotApi | None = None
        self._missions: Missions | None = None
        self._missions_state = missions_state
        self._making_api = threading.Lock()
        self._robot_api_at, self._names = robot_api, names
        self._bridge: ApiBridge | None = None
        api = only_robot_api(self.master_uri, robot_api)
        if api is not None and not watchdog:
            _log.info("%s", say(_NO_WATCHDOG, uri=self.master_uri))
        if isinstance(robot_api, str):
            self._robot_api = self._new_robot_api()  # an invalid address is refused here

        def new_node() -> rosproto.Node:
            bridged = "" if api is None else self._bridged(api)
            return rosproto.Node(
                name,
                master_uri=bridged or self.master_uri,
                host="127.0.0.1" if bridged else host,
                anonymous=True,
                timeout=timeout,
                msg_path=folders,
                resolve=names,
            )

        connection = Connection(self.master_uri, new_node, timeout=timeout, msg_path=folders, robot_api=api)
        facts = Background(lambda: self.robot_api.facts(), 1.0)
        # On this computer another robot may be at the usual port: a simulator, beside a tunnel to this one.
        asked = robot_api is not False and (
            robot_api or api is not None or not is_loopback(parse_uri(self.master_uri)[0])
        )
        self._components = Components(
            connection, leave_running=leave_running, watchdog=watchdog, robot_facts=facts if asked else None
        )
        self._components.motions.carry_out = self._stop

    def __enter__(self) -> Chassis:
        self._components.connection.open_node()  # an unreachable master raises here
        self._components.in_block = True
        self._components.start_watchdog()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except ConnectionLost as problem:
            if kind is None:
                raise
            _log.warning("! %s", problem)  # the exception of the block has precedence

    def close(self) -> None:
        """End velocity blocks, cancel our goals (unless `leave_running`), leave the graph. Idempotent,
        bounded. Nothing begins once it is called; Ctrl-C does not end it halfway.

        Raises:
            ConnectionLost: A goal could not be cancelled: the robot may still be driving. All else is closed.
        """
        motions = self._components.motions
        motions.over = motions.over or _CLOSED  # without a call: no stack may be left, see `immediate_stop`
        if self._missions is not None:
            self._missions.closing = True  # before the stop: that interrupts the run, and does not end it
        motions.note_end(_CLOSED)
        problems = motions.executor.do(self._end, _CLOSE_SECONDS) if motions.moved else []
        if self._missions is not None:
            self._missions.close()
        if self._robot_api is not None:
            self._robot_api.close()
        try:
            motions.executor.do(self._leave, _LEAVE_SECONDS)
        except RosTimeout as late:
            # A frame that a signal handler has interrupted may hold a lock: closing continues afterwards.
            _log.debug("! leaving the graph: %s", late)
        if problems:
            raise ConnectionLost(
                say(
                    "not finished when closing: {what}; the robot may still be driving; use its emergency "
                    "stop button",
                    what="; ".join(problems),
                )
            )

    def _leave(self) -> None:
        self._components.close()
        if self._bridge is not None:
            self._bridge.close()

    def _bridged(self, api: ApiAddress) -> str:
        """The master of the graph in this process."""
        if self._bridge is None:
            from woosh_pure.api_bridge.bridge import ApiBridge

            hosts = HostNames(self._names, master=api.host, quiet=True)
            self._bridge = ApiBridge(api, hosts=hosts, on_refused=self._note_refused).start()
        return self._bridge.master_uri

    def _note_refused(self, why: str) -> None:
        """End the drives: the robot has refused a velocity."""
        self._components.readiness_state.refusals.note(why, time.monotonic())
        for drive in self._components.motions.drives:
            drive.halt(why)

    def _end(self) -> list[str]:
        motions = self._components.motions
        problems = motions.end_all("the Chassis was closed", _CANCEL_SECONDS)
        if motions.drives or (motions.goals and not motions.leave):
            problems = motions.end_all("the Chassis was closed", _LATE_SECONDS)
        return problems

    def __repr__(self) -> str:
        goals = ", ".join(goal.description for goal in self._components.motions.goals) or "nothing"
        return f"<Chassis {self.master_uri}, {self._components.connection.state}: {goals} under way>"

    @property
    def moved(self) -> bool:
        """True when a verb of this object has started a motion, whether it is over or not."""
        return self._components.motions.moved

    @property
    def under_way(self) -> bool:
        """True while something that this object has started may move the robot."""
        motions = self._components.motions
        return bool(motions.goals) or any(not drive.finished for drive in motions.drives)

    @property
    def lease(self) -> ChassisLease:
        """Who commands this robot now, among those who use this object: the page, the REST API, your
        program.

        For a program it is advice (`chassis.lease.holder`), for the page and the REST API a rule.
        """
        return self._lease

    @property
    def robot_api(self) -> RobotApi:
        """The robot's Robot API (JSON on port 5480), if it has one: what ROS 1 does not tell.

        Its own marks with their poses, scenes and maps, zones, outline, identity, task history, events,
        statistics. Nothing else of this class waits for it.

            for mark in chassis.robot_api.marks():
                print(mark.name, mark.pose)
        """
        with self._making_api:
            if self._robot_api is None:
                self._robot_api = self._new_robot_api()
            return self._robot_api

    @property
    def missions(self) -> Missions:
        """Named lists of steps, from `*.mission.toml` files: their queue and the current run."""
        from woosh_pure.missions import Missions

        with self._making_api:
            if self._missions is None:
                self._missions = Missions(self, self._missions_state)
            return self._missions

    def task_list(self, tasks: str | TaskList, *, timeout: float | None = 300.0) -> TaskHandle:
        """Carry out a task list that is stored in the robot (Robot API). Returns at once.

        Args:
            tasks: Its name or id, or one of `robot_api.task_lists()`.
            timeout: Default of the handle's `wait()`, s; None for ever.

        Raises:
            ValueError: There is none of that name, or a stop would not end it.
            MotionRefused: Not ready, another motion of this Chassis is under way, or the robot refused.
            StaleState: The end could not be seen.
            ConnectionLost, RosTimeout: The robot did not answer, or has no Robot API.
        """
        from woosh_pure.motion.task_list import start_task_list, stored_task_list

        api = self.robot_api
        found = stored_task_list(api, tasks) if isinstance(tasks, str) else tasks
        return start_task_list(self._components, api, found, timeout=timeout)

    def _new_robot_api(self) -> RobotApi:
        from woosh_pure.robot_api.api import robot_api_at

        return robot_api_at(self._robot_api_at, self.master_uri, self._names, self._require_idle)

    def _require_idle(self, what: str) -> None:
        """Check that nothing of ours commands the base.

        Raises:
            MotionRefused: Something does.
        """
        self._components.connection.require_open()
        motions = self._components.motions
        motions.require_free_base(what)
        if goals := [goal.description for goal in motions.goals if not goal.done]:
            wrong = "{what} refused, nothing was sent: {goals} is under way; wait for it or cancel it"
            raise MotionRefused(say(wrong, what=what, goals=goals))

    @property
    def node(self) -> rosproto.Node:
        """The underlying node, for everything this class does not offer."""
        return self._components.connection.open_node()

    @property
    def aio(self) -> aio.Chassis:
        """The same for asyncio, every verb, feed and handle awaited: see `woosh_pure.aio`.

        async with Chassis("169.254.128.2").aio as robot:
            await robot.go_to_mark("A1")
        """
        from woosh_pure import aio

        if self._aio is None:
            self._aio = aio.view(self)
        return self._aio

    # -- state
    # ------------------------------------------------------------------------------------------------

    def readiness(self) -> Readiness:
        """Whether it would move now: `answer` is yes, no or not known, `reasons` and `sentence()` say why.

        The answer is "not known" until the chassis has reported its state (`/robot_status` is sent on change
        only): ROS never reports an emergency stop that was pressed before we connected; the Robot API does.
        The result is true only for yes. A refusal is remembered until its cause is shown to be over. The
        check moves and interrupts nothing; see `woosh_pure.readiness`.
        """
        return self._components.readiness_state.readiness()

    def wait_until_ready(self, timeout: float | None = 60.0, *, known: bool = False) -> Readiness:
        """Wait until nothing known blocks a motion, for example after the emergency stop was released.

        The answer may still be "not known": check `answer` of the result, or wait with `known=True`. An idle
        chassis may never report its state.

        State and status codes come on different topics, in any order. So nothing may block for a moment
        before this returns, and a verb called next is not refused for a code that was still on its way.

        Args:
            timeout: Seconds; None waits for ever.
            known: True waits until the answer is yes.

        Raises:
            RosTimeout: Something still blocks, or is not known; the text says what.
            ValueError: `timeout` is negative or NaN.
        """
        timeout = require_timeout(timeout)
        deadline = Deadline(timeout)
        ready_since = math.inf
        while True:
            readiness, now = self.readiness(), time.monotonic()
            ready = readiness.ready or not (known or readiness.blocked)
            ready_since = min(ready_since, now) if ready else math.inf
            if now - ready_since >= _SETTLED:
                return readiness
            if deadline.expired and not ready:
                text = "not ready" if readiness.blocked else "whether it is ready is not known"
                raise RosTimeout(
                    led(say(text), str(readiness)),
                    what="readiness",
                    seconds=timeout,
                )
            time.sleep(0.02)

    def wait_until(
        self, accept: Callable[[values.RobotStatus], bool], timeout: float | None = 60.0
    ) -> values.RobotStatus:
        """Wait for a state: `chassis.wait_until(lambda s: s.robot_state is RobotState.IDLE)`.

        Raises:
            RosTimeout: It did not come in time.
        """
        return self.status.wait_for(accept, timeout)

    # -- velocity --------------------------------------------------------------------------------------------

    @usage("`with chassis.velocity(bypasses_protection=True) as drive: drive.hold(vx, seconds=seconds)`")
    def velocity(
        self,
        *,
        bypasses_protection: bool,
        direct: bool = False,
        max_linear: float | None = None,
        max_angular: float | None = None,
        feedback_timeout: float | None = 1.0,
        check: bool = True,
        share: bool = False,
    ) -> Drive:
        """A block in which the robot is driven by velocity, in base_link (x forward, y left, yaw
        counter-clockwise).

        A velocity passes by the chassis's obstacle avoidance, collision detection, speed and state limits.
        The area must be clear, and a person must watch all the time and be able to stop the robot.

        There is one driver: the block is refused while another program can send velocities, too. The robot's
        own nodes do not count. `drive.others` names those that appear later, with a warning in the log, and
        when such a program is seen to send, the drive is over.

            with chassis.velocity(bypasses_protection=True) as drive:
                drive.hold(0.2, seconds=2.0)

        Enter it at once: a block that was made before a `stop` is refused after it.

        Args:
            bypasses_protection: Must be True: your acknowledgement of the above.
            direct: Use `/base_cmd_vel` (no smoothing) instead of `/smooth_cmd_vel`.
            max_linear: A lower limit than the chassis's own, m/s.
            max_angular: A lower limit than the chassis's own, rad/s.
            feedback_timeout: The drive ends when `/odom_twist` is silent for so long, s. None drives without
                it: then the drive ends when the node that listens does not answer within a second.
            check: False opens and keeps it also when the known state speaks against moving (emergency stop,
                manual mode, a severe fault), while the robot stands although it is told to move, and beside
                a program that came later and sends.
            share: True opens it also beside another program that publishes a velocity topic: you know that
                it is silent while you drive.

        Raises:
            MotionRefused: Not acknowledged, the known state speaks against moving, or (on entering the block)
                another program can send velocities, or `stop` was called since this call.
            ValueError: A limit higher than the chassis's own.
            StaleState: The chassis sends no measured velocity (on entering).
            RosTimeout, ConnectionLost: The velocity topic has no subscriber, or the master is gone.
        """
        since = self._components.motions.since
        if bypasses_protection is not True:
            raise MotionRefused(
                "a velocity bypasses the chassis's obstacle avoidance and limits; "
                "acknowledge it with bypasses_protection=True"
            )
        self._components.readiness_state.require_ready(say("velocity"), check)
        limits = self._drive_limits(max_linear, max_angular)
        topic = VELOCITY_TOPICS["direct" if direct else "smooth"]
        return Drive(self._components, topic, limits, feedback_timeout, since=since, check=check, share=share)

    def _drive_limits(self, max_linear: float | None, max_angular: float | None) -> DriveLimits:
        try:
            known = self.parameters.wait(1.0, new=False)
            linear, angular = known.max_linear, known.max_angular
        except RosTimeout:
            linear = angular = 0.0
        # A limit that is too high for such a base is in another unit, or no limit: use the defaults.
        return DriveLimits(
            _lower("max_linear", linear if 0.0 < linear <= MAX_SPEED else DEFAULT_LINEAR, max_linear),
            _lower(
                "max_angular", angular if 0.0 < angular <= MAX_TURN_RATE else DEFAULT_ANGULAR, max_angular
            ),
        )

    def stop(
        self, *, everything: bool = False, end_drivers: bool = False, timeout: float = 5.0
    ) -> StopReport:
        """Stop: zero velocity, and cancel what this client started. From any thread, at any time, in any
        state.

        It is NO emergency stop: it goes through the network and the chassis's software. Zero goes to
        `/smooth_cmd_vel` and `/base_cmd_vel`, cancels go to `/move_base`, `/cmd_vel_control` and
        `/exec_task`, and `/odom_twist` shows whether the robot stands. Missing topics are not waited for.

        Args:
            everything: Also cancel goals and tasks that others have started. Another program's velocities
                cannot be cancelled: the robot obeys the last message, so it moves on after our zeros. The
                report names such programs.
            end_drivers: Also ask programs that can send velocities to end, as `rosnode kill` does, and send
                zero after them. The robot's own nodes and programs on its computer are left alone.
            timeout: Seconds until the stop must be confirmed by the measured velocity.

        Returns:
            The report: actions, failures, and whether the robot is known to stand still. It never raises
            for a failure: the report says it.
        """
        motions = self._components.motions
        # Without a call: no stack may be left, see `immediate_stop`.
        motions.stop_mark = [True, everything, end_drivers, timeout]
        try:
            return self._stop(everything, end_drivers, timeout)
        except RecursionError:
            if not motions.moved:
                raise  # nothing of ours moves, and there is no thread yet that could do it
            motions.stop_mark = [True, everything, end_drivers, timeout]
            return motions.marked_report

    def _stop(self, everything: bool, end_drivers: bool, timeout: float) -> StopReport:
        return _stop(
            self._components, everything=everything, end_drivers=end_drivers, timeout=stop_seconds(timeout)
        )

    def request(self) -> CallScope:
        """Note that a motion is asked for now, for a program that begins it later.

        A `stop` that comes in between must prevent it: a motion that is begun within the result's block is
        refused if `stop` was called after this call. Without it, a verb counts from its own call. Does not
        wait.

            request = chassis.request()                 # as soon as the command has come
            with request:                               # in the thread that carries it out
                chassis.go_to_mark("A1")
        """
        return self._components.motions.request()

    # -- everything else -------------------------------------------------------------------------------------

    def action(
        self,
        name: str,
        goal: Any,
        *,
        timeout: float | None = 60.0,
        check: bool = True,
        replace: bool = False,
    ) -> ActionHandle:
        """Send a goal to any action server of the chassis: lift, roller, tractor, docking ... Returns at
        once.

        Args:
            name: As in the interface table, for example "/lift_control".
            goal: The goal message; units and frames as its definition says.
            timeout: Default of the handle's `wait()`, s; None for ever.
            check: False sends a goal that moves the whole robot (docking, navigation ...) even when the known
                state speaks against moving, or a velocity block is open.
            replace: True, for such a goal, ends what this Chassis has under way that moves the base.

        Raises:
            KeyError: It is not in the table; the text lists near names.
            ValueError: It is not an action, the goal is of another action, a number is not finite or exceeds
                the interface's limits, or `timeout` is not a time.
            MotionRefused: It moves the robot, which is not ready or is moved by another motion of ours.
            FirmwareLimit: The chassis's definition has no field for a value given; nothing was sent.
            RosTimeout: There is no action server.
        """
        found = interface.row(name)
        if found.kind != "action":
            raise ValueError(say("{name} is a {kind}, not an action", name=found.name, kind=found.kind))
        return start_action(self._components, found, goal, timeout=timeout, check=check, replace=replace)

    def send(self, topic: str, message: Any, *, timeout: float | None = None) -> None:
        """Send a message to any topic the chassis listens to, once it is connected; velocities apart.

        Args:
            topic: As in the interface table, for example "/charge_cmd". Units and frame: see there.
            message: The message, of the topic's type.
            timeout: Seconds for the chassis to connect; None takes this object's own.

        Raises:
            KeyError: It is not in the table; the text lists near names.
            ValueError: It is not a topic to write, the message has another type, or a number is not finite.
            MotionRefused: A velocity topic: those are written inside `with chassis.velocity(...)` only.
            FirmwareLimit: The chassis's definition has no field for a value given; nothing was sent.
            RosTimeout: No node of the chassis subscribes.
        """
        found = interface.row(topic)
        if found.flow != "write":
            wrong = "{name} is a {kind} to {flow}, not a topic to write"
            raise ValueError(say(wrong, name=found.name, kind=found.kind, flow=found.flow))
        if found.bypasses_protection:
            wrong = "{name} passes by the chassis's protection; use `with chassis.velocity(...)`"
            raise MotionRefused(say(wrong, name=found.name))
        given = getattr(message, "_type", type(message).__name__)
        if given != found.type:
            raise ValueError(
                say("{name} takes {type}, got {given}", name=found.name, type=found.type, given=given)
            )
        require_finite(message, found.type)
        self._components.clients.send(found.name, message, require_timeout(timeout))


for _part in (
    Readings,
    MotionVerbs,
    Peripherals,
):  # an error of wrong arguments names the class of the caller
    for _member in vars(_part).values():
        if inspect.isfunction(_member):
            _member.__qualname__ = f"Chassis.{_member.__name__}"


def components_of(chassis: Chassis) -> Components:
    """The parts of a Chassis, for the asyncio API and the commands."""
    return chassis._components


def _lower(name: str, known: float, asked: float | None) -> float:
    asked = as_float(asked)
    if asked is None:
        return known
    if not (math.isfinite(asked) and 0.0 < asked <= known):
        wrong = "{name}={asked}: must be more than 0 and at most the chassis's limit of {known}"
        raise ValueError(say(wrong, name=name, asked=asked, known=known))
    return asked
