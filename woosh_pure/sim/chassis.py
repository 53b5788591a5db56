"""`SimulatedChassis`: the world behind real ROS 1 nodes, over real TCP, at any speed.

    with SimulatedChassis(speed=2) as sim, Chassis(sim.master_uri) as chassis: ...

One thread steps the world at `speed` times real time and publishes; handlers run in the library's threads and
hold `lock` briefly. Stamps are in simulated time, which begins at the time of the start.

Not modelled: the list in `world.py`, and the contents of beacons, RFID and scanners (their topics exist
without messages). Behaviour that the vendor does not document is marked "assumed" in the code.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import rosproto
from rosproto.codec import DynamicMessage, Message
from rosproto.coercion import as_float
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import allow_open_files
from woosh_pure.connection.arguments import require_limit
from woosh_pure.enums import RobotMode
from woosh_pure.firmware.versions import CURRENT
from woosh_pure.firmware.versions import firmware as firmware_named
from woosh_pure.geometry import Pose2D
from woosh_pure.hints import SIMULATED, Hints
from woosh_pure.maps.gridmap import GridMap, grid_message
from woosh_pure.maps.marks import SIMULATED_MARKS, text_of
from woosh_pure.served_graph.stamped import fill_transforms, stamp
from woosh_pure.sim.graph import Graph
from woosh_pure.sim.message_builders import PERIODIC, fill_plan, fill_status
from woosh_pure.sim.motions import PathMotion
from woosh_pure.sim.navigation_client import NavigationClient
from woosh_pure.sim.network import Network
from woosh_pure.sim.planner import Costmap
from woosh_pure.sim.ros_handlers import RosHandlers
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.site import Site
from woosh_pure.sim.world import World
from woosh_pure.values.messages import message_type, stamped_pose
from woosh_pure.values.state import RobotStatus

logger = get_logger("woosh_pure.sim")
MAX_FILES = 1024
"""The nodes of a robot have 50 open files and sockets at rest, and some for each client; above 1024 `select`
would fail in other libraries."""
_TICK = 0.02
_CODE_EVERY = 1.0  # s of wall time after which the last status code is published again
_STEP = 0.02

PLAN_EVERY = 1.0
"""Seconds between two plans while it drives, by move_base's planner_frequency (assumed: 1 Hz)."""
COSTMAP_EVERY = 1.0
"""Seconds between two costmaps while the topic has subscribers (assumed)."""


class SimulatedChassis(Hints):
    """A simulated chassis. Use it in a `with` block, or call `start` and `close`.

    If this process may open fewer than 1024 files (macOS: 256), it raises the limit.

    Args:
        master_uri: Join this master; None starts its own.
        host: Address to bind to; the default is reachable from this computer only.
        port: Port of its own master; 0 uses a free one.
        speed: Simulated seconds per second.
        site: Map and marks; None is the built-in hall.
        settings: Options of the world.
        latch_status: Whether /robot_status is latched, so that each new subscriber receives the state; with
            False it is published on change only (the real behaviour is not known).
        repeat_status_code: Whether /status_code repeats its last code every second; with False each is
            published once (the real behaviour is not known).
        reply_delay: Seconds by which replies of /exec_task are delayed, so that status messages come first.
        full_graph: Add the parts of the real graph without content: second publishers, internal subscribers,
            and the internal clients of /ros_interface.
        firmware: Whose definitions it uses on the wire: a version of the vendor's message package, or "page"
            (`woosh_pure.firmware`).
        assumed_types: Add `/volume/*`, whose definition is not published, with an assumed definition.

    Attributes:
        world: The simulated world; hold `lock` while using it.
        lock: A condition, notified after every step.
        network: Delays and interruptions.
        reply_delay: See above.
        closing: Whether it is closing.
        resets: Number of times that it was reset.
        clock_ahead: Seconds that the robot's clock is ahead of this computer's.
    """

    _hints = SIMULATED

    def __init__(
        self,
        *,
        master_uri: str | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        speed: float = 1.0,
        site: Site | None = None,
        settings: Settings | None = None,
        latch_status: bool = True,
        repeat_status_code: bool = True,
        reply_delay: float = 0.0,
        full_graph: bool = True,
        firmware: str = CURRENT,
        assumed_types: bool = False,
    ) -> None:
        self._speed = _speed_of(speed)
        self.firmware = firmware_named(firmware)
        self.world = World(site, settings)
        self.lock = threading.Condition()
        self.network = Network()
        self.reply_delay = reply_delay
        self.closing = False
        self.resets = 0
        self.clock_ahead = 0.0
        self._epoch = time.time()
        self._given_uri, self._host, self._port = master_uri, host, port
        self._full, self._latch = full_graph, latch_status
        self._assumed_types = assumed_types
        self._master: rosproto.Master | None = None
        self._graph: Graph | None = None
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._navigation: NavigationClient | None = None
        self._due = dict.fromkeys((*PERIODIC, "plan", "tf", "costmap", "code"), 0.0)
        self._status: RobotStatus | None = None
        self._plan: list[Pose2D] = []
        self._costmap: Costmap | None = None
        self._costmap_of: GridMap | None = None
        self._repeats_code = repeat_status_code

    # -- life ------------------------------------------------------------------------------------------------

    def start(self) -> SimulatedChassis:
        """Start master, nodes and world; return this object."""
        if self._thread is not None:
            return self
        allow_open_files(MAX_FILES)
        if self._given_uri is None:
            self._master = rosproto.Master(host=self._host, port=self._port)
            self._port = int(self._master.uri.rstrip("/").rpartition(":")[2])
        try:
            self._build()
        except BaseException:
            self.close()
            raise
        self._epoch = time.time()
        self._thread = threading.Thread(target=self._run, name="woosh:simulation", daemon=True)
        self._thread.start()
        return self

    def _build(self) -> None:
        host = None if self._given_uri else self._host
        handlers = RosHandlers(self)
        handlers.topics["/volume/percentSet"] = self._set_volume
        self._graph = Graph(
            self.master_uri,
            handlers,
            host=host,
            full=self._full,
            latch_status=self._latch,
            firmware=self.firmware,
            network=self.network,
            assumed_types=self._assumed_types,
            own_master=self._master,
        )
        self._graph.build_all()
        self._navigation = NavigationClient(self._graph, self.firmware, self.lock)
        self.world.tasks.drive = self._navigation.drive
        self._publish_static()
        if not self._latch:
            self._status = self.world.status()  # published on change only, and the start is not a change

    def close(self) -> None:
        """Close everything. Idempotent; takes bounded time."""
        with self.lock:
            self.closing = True
            self.lock.notify_all()
        self._stop.set()
        self.network.close()
        if self._thread is not None:
            self._thread.join(2.0)
        if self._navigation is not None:
            self._navigation.close()
        if self._graph is not None:
            self._graph.close()
        if self._master is not None:
            self._master.close()

    def __enter__(self) -> SimulatedChassis:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._thread is None:
            return "<SimulatedChassis, not started>"
        state = "closed" if self.closing else f"{self.speed:g} times real time, {self.world.robot_state}"
        return f"<SimulatedChassis {self.master_uri}, {state}, at {self.world.body.pose}>"

    @property
    def master_uri(self) -> str:
        """The URI of its master."""
        if self._given_uri is not None:
            return self._given_uri
        if self._master is None:
            raise RuntimeError("the simulated chassis is not started; use `with SimulatedChassis() as sim:`")
        return self._master.uri

    @property
    def graph(self) -> Graph:
        """Its nodes and publishers."""
        if self._graph is None:
            raise RuntimeError("the simulated chassis is not started; use `with SimulatedChassis() as sim:`")
        return self._graph

    @property
    def marks(self) -> dict[str, Pose2D]:
        """The marks of its site: name -> pose in the map."""
        return {name: mark.pose for name, mark in self.world.site.marks.items()}

    # -- time ------------------------------------------------------------------------------------------------

    @property
    def speed(self) -> float:
        """Simulated seconds per second, 0.05 to 100; may be set while it runs: 0 stops the simulated time."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        with self.lock:  # no step follows at the former speed
            self._speed = 0.0 if speed == 0 else _speed_of(speed)

    @property
    def now(self) -> float:
        """The robot's time, s since 1970; it jumps ahead if the computer was too busy."""
        return self._epoch + self.world.time + self.clock_ahead

    def _run(self) -> None:
        next_tick = time.monotonic()
        debt = 0.0
        while not self._stop.is_set():
            next_tick += _TICK
            self.network.deliver()
            with self.lock:
                debt += _TICK * self.speed
                while debt >= _STEP and not self.closing:
                    self.world.step(_STEP)
                    debt -= _STEP
                    self._publish_news()
                self.lock.notify_all()
            self._publish()
            rest = next_tick - time.monotonic()
            if rest < -0.5:  # the computer was busy: set the clock instead of catching up
                next_tick -= rest
                self._epoch -= rest
            self._stop.wait(max(rest, 0.001))

    def _publish_news(self) -> None:
        """Publish new codes, and every change of the state, even if it lasts one step only.

        Changes during a silence are lost, but a latched state is published after it, so that it is never old.
        """
        self._publish_new_codes()
        record = self.world.status()
        if record != self._status and not (self._latch and self.network.silent):
            self._status = record
            self._send("/robot_status", fill_status, always=True)

    def _publish(self) -> None:
        if self.network.silent:
            return
        now = time.monotonic()
        for topic, (filler, rate) in PERIODIC.items():
            if now >= self._due[topic]:
                self._due[topic] = now + 1.0 / rate
                with self.lock:
                    self._send(topic, filler)
        with self.lock:
            self._publish_plan()
            if self._repeats_code and now >= self._due["code"]:
                self._publish_code(self.world.last_code)
            if now >= self._due["tf"]:
                self._due["tf"] = now + 0.1
                self._publish_transforms()
        self._publish_costmap(now)

    def _send(
        self, topic: str, filler: Callable[[World, DynamicMessage, float], None], *, always: bool = False
    ) -> None:
        publisher = self.graph.first(topic)
        if publisher is None or not (always or self.graph.is_heard(publisher)):
            return
        if self.network.silent:
            return
        message = message_type(publisher.type_name)()
        filler(self.world, message, self.now)
        _publish(publisher, self.firmware.convert(message, publisher.message_class))

    def _publish_new_codes(self) -> None:
        """Publish new codes, before the state that they explain."""
        for code in self.world.take_reports():
            if not self.network.silent:
                self._publish_code(code)

    def _publish_code(self, code: int) -> None:
        self._due["code"] = time.monotonic() + _CODE_EVERY
        publisher = self.graph.publishers.get((_reporting_node(code), "/status_code")) or self.graph.first(
            "/status_code"
        )
        if publisher is not None:
            _publish(publisher, publisher.message_class(data=code))

    def _publish_plan(self) -> None:
        motion = self.world.motion
        path = [*motion.path] if isinstance(motion, PathMotion) else []
        now = time.monotonic()
        if path and (path[-1:] != self._plan[-1:] or now >= self._due["plan"]):
            publisher = self.graph.first("/move_base/global_plan")
            if publisher is not None:
                self._due["plan"] = now + PLAN_EVERY
                message: Any = publisher.message_class()
                fill_plan([self.world.body.pose, *path], message, self.now)
                _publish(publisher, message)
        self._plan = path

    def _publish_costmap(self, now: float) -> None:
        """Publish the costmap. It is made without the lock, because a large map takes time."""
        publisher = self.graph.costmap
        if publisher is None or not self.graph.is_heard(publisher) or now < self._due["costmap"]:
            return
        self._due["costmap"] = now + COSTMAP_EVERY
        with self.lock:
            grid, obstacles, radius = (
                self.world.map_seen,
                [*self.world.collisions.seen_obstacles],
                self.world.settings.radius,
            )
        if self._costmap is None or self._costmap_of is not grid:
            self._costmap, self._costmap_of = Costmap(grid, radius), grid
        message = grid_message(self._costmap.with_obstacles(obstacles))
        stamp(message, "map", self.now)
        _publish(publisher, self.firmware.convert(message, publisher.message_class))

    def _publish_transforms(self) -> None:
        odometry = self.world.body.odometry
        belief = self.world.believed_pose
        turn = belief.yaw - odometry.yaw
        base = Pose2D(0.0, 0.0, turn).transformed(odometry.x, odometry.y, 0.0)
        for node, link in (
            ("/woosh_localization", ("map", "odom", Pose2D(belief.x - base.x, belief.y - base.y, turn))),
            ("/woosh_robot_pose_ekf", ("odom", "base_link", odometry)),
        ):
            publisher = self.graph.publishers.get((node, "/tf")) or self.graph.first("/tf")
            if publisher is not None and self.graph.is_heard(publisher):
                message: Any = publisher.message_class()
                fill_transforms(message, self.now, link)
                _publish(publisher, message)

    def _publish_static(self) -> None:
        publisher = self.graph.first("/tf_static")
        if publisher is not None:
            message: Any = publisher.message_class()
            here = Pose2D(0.0, 0.0)
            links = [
                ("base_link", child, here) for child in ("laser", "imu", "camera_1_depth", "camera_1_color")
            ]
            fill_transforms(message, self.now, *links)
            publisher.publish(message)
        self._publish_volume(50)
        # No topic or service lists the marks: a parameter tells them to our own commands and pages.
        node = next(iter(self.graph.nodes.values()))
        node.params[SIMULATED_MARKS] = text_of(self.world.site.user_marks().values())

    def _set_volume(self, message: DynamicMessage) -> None:
        self._publish_volume(min(100, message.percent))

    def _publish_volume(self, percent: int) -> None:
        publisher = self.graph.first("/volume/percent")
        if publisher is not None:
            publisher.publish(percent=percent)

    # -- events of the robot ---------------------------------------------------------------------------------

    def reset(self) -> None:
        """Put the robot back to how it was at the start: pose, battery, states, settings, no obstacles or
        faults, and a network without delays. Its tasks and goals fail.

        Nodes that have crashed stay so; `speed` and `reply_delay` are kept.
        """
        self.network.restore()
        self.set_clock(0.0)
        with self.lock:
            self.resets += 1
            self.world.interrupt("the simulation was reset")
            self._publish_news()  # a task's end, which is not in the status of a robot that has just started
            self.world.reset()
            self._publish_news()

    def teleport(self, x: float, y: float, yaw: float | None = None) -> None:
        """Carry the robot to a place, m and rad in the map; None keeps its heading. See `World.teleport`."""
        with self.lock:
            self.world.teleport(x, y, yaw)

    def set_battery(self, percent: float) -> None:
        """Set the charge of the battery, 0 to 100."""
        given = as_float(percent)
        if not 0.0 <= given <= 100.0:
            raise ValueError(say("battery {percent}: expected 0 to 100 percent", percent=given))
        with self.lock:
            self.world.battery.percent = given

    def press_emergency_stop(self) -> None:
        """Press the emergency stop button."""
        with self.lock:
            self.world.press_emergency_stop()

    def release_emergency_stop(self) -> None:
        """Release the emergency stop button; nothing resumes."""
        with self.lock:
            self.world.release_emergency_stop()

    def release_bumper(self) -> None:
        """Release the bumper after a collision; nothing resumes."""
        with self.lock:
            self.world.release_bumper()

    def lose_localization(self) -> None:
        """Lose the localisation."""
        with self.lock:
            self.world.lose_localization()

    def set_mode(self, mode: RobotMode) -> None:
        """Turn the key switch."""
        with self.lock:
            self.world.set_mode(mode)

    def plug_cable(self, plugged: bool = True) -> None:
        """Plug the charging cable in or out."""
        with self.lock:
            self.world.plug_cable(plugged)

    def fail_task(self, message: str = "injected failure") -> None:
        """Fail the running task, or the next one."""
        with self.lock:
            self.world.tasks.fail_next = message

    def add_obstacle(self, x: float, y: float, radius: float = 0.25) -> None:
        """Add a round obstacle; m in the map."""
        with self.lock:
            self.world.obstacles.append((x, y, radius))

    def remove_obstacles(self) -> None:
        """Remove all obstacles."""
        with self.lock:
            self.world.obstacles.clear()

    def report(self, code: int) -> None:
        """Publish a status code."""
        with self.lock:
            self.world.report(code)

    def fall_silent(self, seconds: float) -> None:
        """Stop the topics that the chassis publishes for a while; commands still arrive."""
        self.network.fall_silent(require_limit(seconds, "seconds"))

    def drop_link(self, seconds: float) -> None:
        """Interrupt the network for a while in both directions. Messages sent meanwhile arrive afterwards, as
        with TCP, velocities included.
        """
        self.network.drop(require_limit(seconds, "seconds"))

    def slow_network(self, delay: float) -> None:
        """Delay topics, commands, requests and goals by `delay` s each way; 0 ends it."""
        self.network.delay = require_limit(delay, "delay")

    def set_clock(self, ahead: float) -> None:
        """Set the robot's clock to `ahead` seconds before this computer's time; negative: behind it."""
        self.clock_ahead = as_float(ahead)
        for node in self.graph.nodes.values():
            node.clock.ahead_nsec = round(self.clock_ahead * 1e9)

    def crash_node(self, name: str) -> None:
        """Close one of its nodes, as after a crash."""
        if name not in self.graph.nodes:
            raise ValueError(
                say(
                    "{name} is not a node of this chassis; it has {names}",
                    name=name,
                    names=", ".join(sorted(self.graph.nodes)),
                )
            )
        self.graph.nodes[name].close()
        if name == "/move_base":
            with self.lock:
                self.world.tasks.fail("navigation failed")  # its client notices (assumed)

    def compete(self, x: float, y: float, yaw: float = 0.0) -> None:
        """Send a goal to /move_base from the robot's own /ros_interface, as for its own tasks."""
        client = self.graph.client("/move_base")
        client.wait_for_server(5.0)
        goal = message_type("woosh_msgs/MoveBaseGoal")()
        goal.target_pose = stamped_pose(Pose2D(x, y, yaw))
        client.send_goal(self.firmware.convert(goal, client.type.goal))

    def restart_master(self) -> None:
        """Restart the master on the same port, without registrations."""
        if self._master is None:
            raise RuntimeError("this chassis uses a master that is not its own")
        self._master.close()
        self._master = rosproto.Master(host=self._host, port=self._port)
        self.graph.check_master_now()

    @property
    def pose(self) -> Pose2D:
        """The true pose of the robot."""
        with self.lock:
            return self.world.body.pose


def _speed_of(given: float) -> float:
    speed = as_float(given)
    if not 0.05 <= speed <= 100.0:
        raise ValueError(say("speed {speed}: expected 0.05 to 100 simulated seconds per second", speed=speed))
    return speed


def _publish(publisher: rosproto.Publisher, message: Message) -> None:
    """Publish, unless the node has crashed."""
    try:
        publisher.publish(message)
    except RosError as error:
        logger.debug("! publishing failed: %s", error)


def _reporting_node(code: int) -> str:
    """The node that reports a code (assumed from its department)."""
    text = f"{code:012d}"
    if text[1:4] == "301":
        return "/woosh_localization" if text[4:6] == "03" else "/move_base"
    return "/mobile_base_nodelet_manager"
