"""`SimulatedChassis`: the world behind real ROS 1 nodes, over real TCP, at any speed.

    with SimulatedChassis(speed=2) as sim, Chassis(sim.master_uri) as chassis: ...

One thread drives the world in wall time times `speed` and publishes; handlers run in the library's threads
and take `lock` for a moment. Stamps run with simulated time, from the moment of the start.

Not modelled: what `world` names, the contents of beacons, RFID and scanners (their topics exist and are
silent), and what a real chassis does where its documentation is silent; such places are marked "assumed" in
the code.
"""

from __future__ import annotations

import math
import threading
import time
from types import TracebackType
from typing import Any

import rosproto
from rosproto.coercion import as_float
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.transport import allow_open_files
from woosh_pure.enums import RobotMode
from woosh_pure.firmware.versions import CURRENT
from woosh_pure.firmware.versions import firmware as firmware_named
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap, grid_message
from woosh_pure.sim.costmap import Costmap
from woosh_pure.sim.graph import Graph
from woosh_pure.sim.message_builders import FILLERS, RATES, fill_plan, fill_status, fill_transforms, stamp
from woosh_pure.sim.motions import PathMotion
from woosh_pure.sim.navigation_client import NavigationClient
from woosh_pure.sim.network import Network
from woosh_pure.sim.ros_handlers import Server
from woosh_pure.sim.settings import Settings
from woosh_pure.sim.site import Site
from woosh_pure.sim.tasks import StatusRecord
from woosh_pure.sim.world import World
from woosh_pure.values.messages import message_type

logger = get_logger("woosh_pure.sim")
MOST_FILES = 1024
"""Forty nodes and a few clients have 600 open, sockets included; beyond 1024 others' `select` would fail."""
_TICK = 0.02
_CODE_EVERY = 1.0  # s of wall time after which the last status code is said again
_STEP = 0.02

PLAN_EVERY = 1.0
"""Seconds between two plans while it drives, as move_base's planner_frequency makes it (assumed: 1 Hz)."""
COSTMAP_EVERY = 1.0
"""Seconds between two costmaps, while somebody listens (assumed)."""


class SimulatedChassis:
    """A chassis without a robot. Use it in a `with` block, or call `start` and `close`.

    Where the system lets this process open fewer than 1024 files (macOS: 256), it is asked for as many.

    Args:
        master_uri: Join this master; None starts one of its own.
        host: Address to bind to; the default is reachable from this computer only.
        port: Port of its own master; 0 takes a free one.
        speed: Simulated seconds per second.
        site: Map and marks; None is the built-in hall.
        settings: Options of the world.
        latch_status: Whether /robot_status is latched, so that each new subscriber is told the state; False
            says it on change only, so that a later subscriber hears nothing (not known of the real one).
        repeat_status_code: Whether /status_code says its last code again every second; False says each once,
            so that a later subscriber hears nothing (not known of the real one).
        reply_delay: Seconds by which /exec_task answers late, so that status messages come first.
        full_graph: Also the parts of the real graph that carry no content: second publishers, internal
            listeners,
            the internal clients of /ros_interface.
        firmware: Whose definitions it speaks on the wire: a version of the vendor's message package, or
            "page" (`woosh_pure.firmware`).
        assumed_types: Also `/volume/*`, whose definition is not published, with a definition of ours.

    Attributes:
        world: The simulated world; hold `lock` while touching it.
        lock: A condition, notified after every step.
    """

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
        speed = as_float(speed)
        if not 0.05 <= speed <= 100.0:
            raise ValueError(
                say("speed {speed}: expected 0.05 to 100 simulated seconds per second", speed=speed)
            )
        self.firmware = firmware_named(firmware)
        self.world = World(site, settings)
        self.lock = threading.Condition()
        self.speed = speed
        self.reply_delay = reply_delay
        self.closing = False
        self._given_uri, self._host, self._port = master_uri, host, port
        self._full, self._latch = full_graph, latch_status
        self._assumed_types = assumed_types
        self._master: rosproto.Master | None = None
        self._graph: Graph | None = None
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._epoch = time.time()
        self.network = Network()
        self._navigation: NavigationClient | None = None
        self._due = dict.fromkeys(FILLERS, 0.0)
        self._status: StatusRecord | None = None
        self._plan: list[Pose2D] = []
        self._plan_due = 0.0
        self._tf_due = 0.0
        self._costmap: Costmap | None = None
        self._costmap_of: GridMap | None = None
        self._costmap_due = 0.0
        self._repeats_code = repeat_status_code
        self._code_due = 0.0

    # -- life ------------------------------------------------------------------------------------------------

    def start(self) -> SimulatedChassis:
        """Bring master, nodes and world up; returns this object."""
        if self._thread is not None:
            return self
        allow_open_files(MOST_FILES)
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
        self._graph = Graph(
            self.master_uri,
            Server(self),
            host=host,
            full=self._full,
            latch_status=self._latch,
            firmware=self.firmware,
            network=self.network,
            assumed_types=self._assumed_types,
            own_master=self._master,
        )
        self._graph.build()
        self._navigation = NavigationClient(self._graph, self.firmware, self.lock)
        self.world.tasks.drive = self._navigation.drive
        self._publish_static()
        if not self._latch:
            self._status = self.world.status()  # told on change only, and the start is none

    def close(self) -> None:
        """Take everything down; idempotent, bounded."""
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
        """Where to connect."""
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
    def now(self) -> float:
        """Simulated time of day, s since 1970; it skips what a busy computer has lost."""
        return self._epoch + self.world.time

    # -- time ------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        next_tick = time.monotonic()
        debt = 0.0
        while not self._stop.is_set():
            next_tick += _TICK
            debt += _TICK * self.speed
            self.network.deliver()
            with self.lock:
                while debt >= _STEP and not self.closing:
                    self.world.step(_STEP)
                    debt -= _STEP
                    self._note_codes()
                    self._note_status()
                self.lock.notify_all()
            self._publish()
            rest = next_tick - time.monotonic()
            if rest < -0.5:  # the computer was busy: the clock is set, and the robot does not hurry
                next_tick -= rest
                self._epoch -= rest
            self._stop.wait(max(rest, 0.001))

    def _note_status(self) -> None:
        """On change, and every change: a state that lasts one step only is published too.

        What changes in a silence is lost, but a latched state is told after it: newcomers get no old one.
        """
        record = self.world.status()
        if record != self._status and not (self._latch and self.network.silent):
            self._status = record
            self._send("/robot_status", fill_status, always=True)

    def _publish(self) -> None:
        if self.network.silent:
            return
        now = time.monotonic()
        for topic, filler in FILLERS.items():
            if now >= self._due[topic]:
                self._due[topic] = now + 1.0 / RATES[topic]
                with self.lock:
                    self._send(topic, filler)
        with self.lock:
            self._publish_plan()
            if self._repeats_code and now >= self._code_due:
                self._say_code(self.world.last_code)
            if now >= self._tf_due:
                self._tf_due = now + 0.1
                self._publish_transforms()
        self._publish_costmap(now)

    def _send(self, topic: str, filler: Any, *, always: bool = False) -> None:
        publisher = self.graph.first(topic)
        if publisher is None or not (always or publisher.connections):
            return
        if self.network.silent:
            return
        message = message_type(publisher.type_name)()
        filler(self.world, message, self.now)
        _publish(publisher, self.firmware.convert(message, publisher.message_class))

    def _note_codes(self) -> None:
        """Before the state they explain: two topics, but at least sent in the order of what happened."""
        for code in self.world.take_reports():
            if not self.network.silent:
                self._say_code(code)

    def _say_code(self, code: int) -> None:
        self._code_due = time.monotonic() + _CODE_EVERY
        publisher = self.graph.publishers.get((_speaker(code), "/status_code")) or self.graph.first(
            "/status_code"
        )
        if publisher is not None:
            _publish(publisher, publisher.message_class(data=code))

    def _publish_plan(self) -> None:
        motion = self.world.motion
        path = [*motion.path] if isinstance(motion, PathMotion) else []
        now = time.monotonic()
        if path and (path[-1:] != self._plan[-1:] or now >= self._plan_due):
            publisher = self.graph.first("/move_base/global_plan")
            if publisher is not None:
                self._plan_due = now + PLAN_EVERY
                message = publisher.message_class()
                fill_plan([self.world.body.pose, *path], message, self.now)
                _publish(publisher, message)
        self._plan = path

    def _publish_costmap(self, now: float) -> None:
        """Outside of the lock: a large map takes a moment."""
        publisher = self.graph.costmap
        if publisher is None or not publisher.connections or now < self._costmap_due:
            return
        self._costmap_due = now + COSTMAP_EVERY
        with self.lock:
            grid, things, radius = self.world.map_seen, [*self.world.around.seen], self.world.settings.radius
        if self._costmap is None or self._costmap_of is not grid:
            self._costmap, self._costmap_of = Costmap(grid, radius), grid
        message = grid_message(self._costmap.with_things(things))
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
            if publisher is not None and publisher.connections:
                message = publisher.message_class()
                fill_transforms(message, self.now, link)
                _publish(publisher, message)

    def _publish_static(self) -> None:
        publisher = self.graph.first("/tf_static")
        if publisher is not None:
            message = publisher.message_class()
            here = Pose2D(0.0, 0.0)
            links = [
                ("base_link", child, here) for child in ("laser", "imu", "camera_1_depth", "camera_1_color")
            ]
            fill_transforms(message, self.now, *links)
            publisher.publish(message)
        volume = self.graph.first("/volume/percent")
        if volume is not None:
            volume.publish(percent=50)

    # -- things that happen to a robot -----------------------------------------------------------------------

    def press_emergency_stop(self) -> None:
        """Somebody presses the red button."""
        with self.lock:
            self.world.press_emergency_stop()

    def release_emergency_stop(self) -> None:
        """The button is pulled out again; nothing resumes."""
        with self.lock:
            self.world.release_emergency_stop()

    def release_bumper(self) -> None:
        """Somebody has freed the robot that hit something; nothing resumes."""
        with self.lock:
            self.world.release_bumper()

    def lose_localization(self) -> None:
        """The robot no longer knows where it is."""
        with self.lock:
            self.world.lose_localization()

    def set_mode(self, mode: RobotMode) -> None:
        """The key switch."""
        with self.lock:
            self.world.set_mode(mode)

    def plug_cable(self, plugged: bool = True) -> None:
        """The charging cable."""
        with self.lock:
            self.world.plug_cable(plugged)

    def fail_task(self, message: str = "injected failure") -> None:
        """The running task, or the next one, fails."""
        with self.lock:
            self.world.tasks.fail_next = message

    def add_obstacle(self, x: float, y: float, radius: float = 0.25) -> None:
        """Put something round in the way, m in the map."""
        with self.lock:
            self.world.obstacles.append((x, y, radius))

    def remove_obstacles(self) -> None:
        """Take everything away again."""
        with self.lock:
            self.world.obstacles.clear()

    def report(self, code: int) -> None:
        """Publish a status code."""
        with self.lock:
            self.world.report(code)

    def fall_silent(self, seconds: float) -> None:
        """The topics the chassis publishes by itself end for a while; commands still arrive."""
        self.network.fall_silent(_seconds("seconds", seconds))

    def drop_link(self, seconds: float) -> None:
        """The cable is pulled for a while: nothing arrives, in either direction. What was sent meanwhile
        arrives afterwards, as TCP delivers it; a velocity, too.
        """
        self.network.drop(_seconds("seconds", seconds))

    def slow_network(self, delay: float) -> None:
        """Everything takes `delay` s each way from now on: topics, commands, requests, goals; 0 ends it."""
        self.network.delay = _seconds("delay", delay)

    def crash_node(self, name: str) -> None:
        """End one of its nodes."""
        if name not in self.graph.nodes:
            raise ValueError(
                say(
                    "{name} is no node of this chassis; it has {names}",
                    name=name,
                    names=", ".join(sorted(self.graph.nodes)),
                )
            )
        self.graph.nodes[name].close()
        if name == "/move_base":
            with self.lock:
                self.world.tasks.fail("navigation failed")  # its client notices (assumed)

    def compete(self, x: float, y: float, yaw: float = 0.0) -> None:
        """The robot's own /ros_interface sends a goal to /move_base, as it does for its own tasks."""
        from woosh_pure.values.messages import stamped_pose

        client = self.graph.client("/move_base")
        client.wait_for_server(5.0)
        goal = message_type("woosh_msgs/MoveBaseGoal")()
        goal.target_pose = stamped_pose(Pose2D(x, y, yaw))
        client.send_goal(self.firmware.convert(goal, client.type.goal))

    def restart_master(self) -> None:
        """The master ends and comes back empty on the same port."""
        if self._master is None:
            raise RuntimeError("this chassis uses a master that is not its own")
        self._master.close()
        self._master = rosproto.Master(host=self._host, port=self._port)
        self.graph.look_at_master()

    @property
    def pose(self) -> Pose2D:
        """Where the robot really is."""
        with self.lock:
            return self.world.body.pose


def _publish(publisher: rosproto.Publisher, message: Any) -> None:
    """Publish, unless its node has crashed: the others live on."""
    try:
        publisher.publish(message)
    except RosError as error:
        logger.debug("! publishing failed: %s", error)


def _seconds(name: str, value: float) -> float:
    """A time of the caller's, as a float: one that is none would end the simulation later, in its thread."""
    seconds = as_float(value)
    if not 0.0 <= seconds < math.inf:
        raise ValueError(
            say("{name}={value!r}: expected seconds of at least 0, and not for ever", name=name, value=value)
        )
    return seconds


def _speaker(code: int) -> str:
    """Which node reports a code (assumed from its department)."""
    text = f"{code:012d}"
    if text[1:4] == "301":
        return "/woosh_localization" if text[4:6] == "03" else "/move_base"
    return "/mobile_base_nodelet_manager"
