"""The asyncio `Chassis`: wraps each verb of the threaded one."""

from __future__ import annotations

import functools
import inspect
import logging
from collections.abc import Callable, Coroutine, Generator
from types import TracebackType
from typing import Any, Concatenate, ParamSpec, TypeVar

from rosproto import aio as ros
from rosproto.aio import SameProperty
from rosproto.logs import get_logger
from woosh_pure import values
from woosh_pure.aio.calls import AwaitableProperty, ThreadCalls, in_loop
from woosh_pure.aio.drive import VelocityBlock
from woosh_pure.aio.feed import Readings
from woosh_pure.aio.goals import ActionHandle, Goal, GoalHandle, NavigationHandle, StepHandle, TaskHandle
from woosh_pure.chassis import Chassis as Threaded
from woosh_pure.chassis import components_of
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.faults import Faults
from woosh_pure.hints import CHASSIS, SettingHints
from woosh_pure.lease import ChassisLease
from woosh_pure.missions import Missions as ThreadedMissions
from woosh_pure.missions import State
from woosh_pure.motion import motion as threaded
from woosh_pure.robot_api.api import RobotApi as ThreadedApi
from woosh_pure.stopping.report import StopReport
from woosh_pure.velocity.drive import Drive

# -- from a verb of the threaded `Chassis` to the awaited one: same name, same arguments, same types ---------
#
# Type checkers (by a ParamSpec), `help` and `inspect.signature` see the signature of the threaded verb, so it
# is written only once.

P = ParamSpec("P")
R = TypeVar("R")
H = TypeVar("H", bound=GoalHandle[Any])


def like(method: Callable[..., Any], made: R, returns: str = "") -> R:
    """Copy name, documentation and signature of a threaded verb to the awaited one; `returns` replaces its
    return type."""
    functools.update_wrapper(made, method)  # type: ignore[arg-type]  # a function, of whatever type
    signature = inspect.signature(method)
    if returns:
        signature = signature.replace(return_annotation=returns)
    vars(made)["__signature__"] = signature
    vars(made).pop("__wrapped__")
    return made


def verb(
    method: Callable[Concatenate[Any, P], R], *, stops: bool = False
) -> Callable[Concatenate[Chassis, P], Coroutine[Any, Any, R]]:
    """An awaited verb. Cancelling it drops everything not yet sent; one that `stops` always completes, and a
    cancelled task waits for it.
    """

    async def call(self: Chassis, /, *args: P.args, **kwargs: P.kwargs) -> R:
        run = self._calls.finish if stops else self._calls.call
        try:
            return await run(lambda: method(self.chassis, *args, **kwargs))
        except RecursionError:
            if not stops:
                raise
            return method(self.chassis, *args, **kwargs)  # which needs less stack than another thread

    return like(method, call)


def goal(
    method: Callable[Concatenate[Any, P], threaded.GoalHandle[Any]], handle: type[H]
) -> Callable[Concatenate[Chassis, P], Goal[H]]:
    """A verb that starts a goal: see `Goal`."""

    def begin(self: Chassis, /, *args: P.args, **kwargs: P.kwargs) -> Goal[H]:
        def send() -> threaded.GoalHandle[Any]:
            return method(self.chassis, *args, **kwargs)

        return Goal(method.__name__, self._calls, send, handle)

    return like(method, begin, f"Goal[{handle.__name__}]")


def block(
    method: Callable[Concatenate[Any, P], Drive],
) -> Callable[Concatenate[Chassis, P], VelocityBlock]:
    """The verb that opens a velocity block."""

    def begin(self: Chassis, /, *args: P.args, **kwargs: P.kwargs) -> VelocityBlock:
        return VelocityBlock(self._calls, lambda: method(self.chassis, *args, **kwargs))

    return like(method, begin, "VelocityBlock")


def answer(
    method: Callable[Concatenate[Any, P], R],
) -> Callable[Concatenate[Any, P], Coroutine[Any, Any, R]]:
    """An awaited question to the Robot API or the missions: what a class has as `api`."""

    async def call(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        answered: R = await self._calls.call(lambda: method(self.api, *args, **kwargs))
        return answered

    return like(method, call)


class RobotApi:
    """The Robot API of one robot, by plain HTTP: `chassis.robot_api`.

    Attributes:
        api: The underlying threaded `RobotApi`.
    """

    def __init__(self, api: ThreadedApi, calls: ThreadCalls) -> None:
        self.api, self._calls = api, calls

    available = answer(ThreadedApi.available)
    request = answer(ThreadedApi.request)
    identity = answer(ThreadedApi.identity)
    facts = answer(ThreadedApi.facts)
    outline = answer(ThreadedApi.outline)
    settings = answer(ThreadedApi.settings)
    scene = answer(ThreadedApi.scene)
    scenes = answer(ThreadedApi.scenes)
    marks = answer(ThreadedApi.marks)
    zones = answer(ThreadedApi.zones)
    switch_map = answer(ThreadedApi.switch_map)
    task_history = answer(ThreadedApi.task_history)
    task_lists = answer(ThreadedApi.task_lists)
    events = answer(ThreadedApi.events)
    unresolved = answer(ThreadedApi.unresolved)
    statistics = answer(ThreadedApi.statistics)


awaited = answer  # a method of the next class has its name


class Missions:
    """The missions of one robot, see `woosh_pure.missions.Missions`. A handle is awaited for its end.

        handle = await robot.missions.run("round.mission.toml")
        run = await handle

    Attributes:
        api: The underlying threaded `Missions`.
    """

    def __init__(self, api: ThreadedMissions, calls: ThreadCalls) -> None:
        self.api, self._calls = api, calls

    async def stop(self, *, by: str = "program") -> StopReport:
        """Stop the robot, end the run as stopped, and pause the queue. It completes once it is called."""
        return await self._calls.finish(lambda: self.api.stop(by=by))

    state = SameProperty[State](ThreadedMissions.state, "api")
    list = awaited(ThreadedMissions.list)
    path = awaited(ThreadedMissions.path)
    load = awaited(ThreadedMissions.load)
    save = awaited(ThreadedMissions.save)
    remove = awaited(ThreadedMissions.remove)
    run = awaited(ThreadedMissions.run)
    append = awaited(ThreadedMissions.append)
    unqueue = awaited(ThreadedMissions.unqueue)
    clear = awaited(ThreadedMissions.clear)
    reorder = awaited(ThreadedMissions.reorder)
    pause = awaited(ThreadedMissions.pause)
    resume = awaited(ThreadedMissions.resume)
    answer = awaited(ThreadedMissions.answer)
    find = awaited(ThreadedMissions.find)
    wait_for = awaited(ThreadedMissions.wait_for)
    add_webhook = awaited(ThreadedMissions.add_webhook)


_log: logging.Logger = get_logger("woosh_pure.aio")


def _made_like(
    threaded: Callable[Concatenate[Any, P], None],
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, P], None]]:
    def made(initialise: Callable[..., None]) -> Callable[Concatenate[Any, P], None]:
        return like(threaded, initialise)

    return made


class Chassis(Readings, SettingHints):
    """One chassis, for asyncio. Names, arguments, values and errors are those of `woosh_pure.Chassis`.

        async with Chassis("169.254.128.2") as robot:
            await robot.go_to_mark("A1")

    Entering the block connects; leaving it cancels running goals and leaves the graph. `Chassis(...).aio`
    is the same for an existing `woosh_pure.Chassis`: leaving `async with chassis.aio` closes it. Inside the
    chassis's own `with` block it only ends the motions begun in the inner block.

    Reading: `await robot.battery` (the newest value, or the first), `async for pose in robot.pose`, and
    `latest`, `age` ... without waiting; `await robot.faults`, `await robot.readiness()`.
    Moving: `await robot.go_to_mark("A1")` returns on arrival, or raises `GoalFailed`; `async with
    robot.go_to_mark("A1") as handle` and `await robot.go_to_mark("A1").start()` give a handle (see `Goal`).
    Driving by velocity: `async with robot.velocity(bypasses_protection=True) as drive`.
    Everything else is awaited: `await robot.stop()`, `await robot.get_map()`, `await robot.say("hello")`.

    Cancelling a task (by `asyncio.timeout`, a TaskGroup, Ctrl-C in `asyncio.run` ...) ends its motions at any
    point: unsent commands are dropped, a goal is cancelled and a velocity block ends before the task ends, in
    bounded time. `stop`, `cancel`, `pause` and `close` complete once called.

    Attributes:
        chassis: The underlying threaded `Chassis`.
    """

    _hints = CHASSIS

    @_made_like(Threaded.__init__)
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._attach(Threaded(*args, **kwargs))

    def _attach(self, chassis: Threaded) -> None:
        self.chassis: Threaded = chassis
        self._calls = ThreadCalls(components_of(chassis).motions.request)
        self._depth = 0
        self._shared = False

    def __repr__(self) -> str:
        return f"<aio {repr(self.chassis)[1:]}"

    # -- opening and closing

    def __await__(self) -> Generator[Any, None, Chassis]:
        """Connect without a block: `robot = await Chassis(...)`; call `await robot.close()` at the end."""
        return self._connect().__await__()

    async def _connect(self) -> Chassis:
        chassis = self.chassis
        if components_of(chassis).in_block:
            await self._calls.call(lambda: chassis.node)
        else:
            await self._calls.opened(lambda: chassis.node, lambda _: chassis.close())
        return self

    async def __aenter__(self) -> Chassis:
        if not self._depth:
            self._shared = components_of(self.chassis).in_block
        await self._connect()
        self._depth += 1
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._depth -= 1
        if self._depth:
            return
        leave = self._end_begun if self._shared else lambda: self.chassis.__exit__(kind, error, trace)
        if kind is GeneratorExit:  # the loop was closed inside the block
            self._calls.spawn(leave)
            return
        try:
            await self._calls.finish(leave)
        finally:
            self._calls.close()

    def _end_begun(self) -> None:
        motions = components_of(self.chassis).motions
        for drive in motions.drives:
            if drive in self._calls.begun:
                drive.abandon()
        for under_way in [] if motions.leave else motions.goals:
            if under_way in self._calls.begun:
                motions.end(under_way, 3.0)

    async def close(self) -> None:
        """End velocity blocks, cancel our goals (unless `leave_running`), leave the graph. Idempotent,
        bounded; it completes even if this task is cancelled.

        Raises:
            ConnectionLost: A goal could not be cancelled: the robot may still be driving. All else is closed.
        """
        try:
            await self._calls.finish(self.chassis.close)
        finally:
            self._calls.close()

    # -- state

    @property
    def master_uri(self) -> str:
        """Where its master is."""
        return self.chassis.master_uri

    moved = SameProperty[bool](Threaded.moved, "chassis")
    lease = SameProperty[ChassisLease](Threaded.lease, "chassis")
    under_way = SameProperty[bool](Threaded.under_way, "chassis")

    def request(self) -> CallScope:
        """Note that a motion is asked for now, for a program that begins it later.

        A `stop` that comes in between must prevent it: a motion that is begun within the result's block is
        refused if `stop` was called after this call. Without it, a verb counts from when it is awaited. Does
        not wait.

            request = robot.request()                   # as soon as the command has come
            with request:                               # in the task that carries it out
                await robot.go_to_mark("A1")
        """
        return self.chassis.request()

    @property
    def robot_api(self) -> RobotApi:
        """The robot's Robot API (JSON on port 5480), if it has one: what ROS 1 does not tell.

        for mark in await robot.robot_api.marks(): ...
        """
        return RobotApi(self.chassis.robot_api, self._calls)

    @property
    def missions(self) -> Missions:
        """Named lists of steps, from `*.mission.toml` files: their queue and the current run.

        await (await robot.missions.run("round.mission.toml"))
        """
        return Missions(self.chassis.missions, self._calls)

    @property
    def node(self) -> AwaitableProperty[ros.Node]:
        """`await robot.node` is the node underneath, for everything this class does not offer: a view by
        `rosproto.aio`.
        """
        return AwaitableProperty(self._node)

    async def _node(self) -> ros.Node:
        return ros.view(await self._calls.call(lambda: self.chassis.node))

    @property
    def faults(self) -> AwaitableProperty[Faults]:
        """`await robot.faults` are the faults active now, the worst first; only what was heard since this was
        first asked.
        """
        return AwaitableProperty(lambda: self._calls.call(lambda: self.chassis.faults))

    @property
    def connected(self) -> AwaitableProperty[bool]:
        """`await robot.connected`: whether the chassis is heard, see `woosh_pure.Chassis.connected`."""
        return AwaitableProperty(lambda: self._calls.call(lambda: self.chassis.connected))

    def on_connection(self, callback: Callable[[bool], object]) -> Callable[[], None]:
        """Call `callback(connected)` at once, and whenever it changes; returns a function that ends this.

        It is called in this loop.
        """
        return self.chassis.on_connection(in_loop(callback))

    async def wait_until(
        self, accept: Callable[[values.RobotStatus], bool], timeout: float | None = 60.0
    ) -> values.RobotStatus:
        """Wait for a state: `await robot.wait_until(lambda s: s.robot_state is RobotState.IDLE)`.

        Raises:
            RosTimeout: It did not come in time.
        """
        return await self.status.wait_for(accept, timeout)

    snapshot = verb(Threaded.snapshot)
    readiness = verb(Threaded.readiness)
    wait_until_ready = verb(Threaded.wait_until_ready)

    # -- moving

    go_to_mark = goal(Threaded.go_to_mark, TaskHandle)
    task = goal(Threaded.task, TaskHandle)
    park = goal(Threaded.park, TaskHandle)
    charge = goal(Threaded.charge, TaskHandle)
    carry = goal(Threaded.carry, TaskHandle)
    task_list = goal(Threaded.task_list, TaskHandle)
    go_to = goal(Threaded.go_to, NavigationHandle)
    follow = goal(Threaded.follow, NavigationHandle)
    move = goal(Threaded.move, StepHandle)
    rotate = goal(Threaded.rotate, StepHandle)
    forward = goal(Threaded.forward, StepHandle)
    left = goal(Threaded.left, StepHandle)
    right = goal(Threaded.right, StepHandle)
    strafe = goal(Threaded.strafe, StepHandle)
    move_diagonal = goal(Threaded.move_diagonal, StepHandle)
    steps = goal(Threaded.steps, StepHandle)
    action = goal(Threaded.action, ActionHandle)
    velocity = block(Threaded.velocity)
    stop = verb(Threaded.stop, stops=True)

    # -- everything else

    send = verb(Threaded.send)
    set_pose = verb(Threaded.set_pose)
    initialise = verb(Threaded.initialise)
    start_localization = verb(Threaded.start_localization)
    light = verb(Threaded.light)
    say = verb(Threaded.say)
    set_footprint = verb(Threaded.set_footprint)
    enable_costmaps = verb(Threaded.enable_costmaps)
    clear_costmaps = verb(Threaded.clear_costmaps)
    get_map = verb(Threaded.get_map)
    set_map = verb(Threaded.set_map)
    plan = verb(Threaded.plan)
    set_navigation_mode = verb(Threaded.set_navigation_mode)


def view(chassis: Threaded) -> Chassis:
    """The asyncio API of an existing Chassis, as `chassis.aio`; both may be used at the same time."""
    face = Chassis.__new__(Chassis)
    face._attach(chassis)
    return face
