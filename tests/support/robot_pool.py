"""Simulated chassis that serve one test after the other: starting a graph costs more than most tests do with it.

Each test gets a chassis in its initial state: a new world, an unchanged network, no goals, no other nodes at the
master. A chassis whose graph a test has changed (crashed a node, closed a publisher, restarted the master, pulled the
cable) is discarded.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import rosproto
from rosproto.errors import RosError
from rosproto.protocol.goal_server import GoalList
from woosh_pure import SimulatedChassis

__all__ = ["RobotPool"]

PATIENCE = 2.0  # s for the rest of a test to end: nodes unregister, handlers return


class RobotPool:
    """Holds at most one unused simulated chassis. Use it in a `with` block, from one thread.

    Args:
        options: Of each `SimulatedChassis`; speed apart.
    """

    def __init__(self, **options: Any) -> None:
        self._options = options
        self._free: Robot | None = None

    def __enter__(self) -> RobotPool:
        return self

    def __exit__(self, *_: object) -> None:
        if self._free is not None:
            self._free.sim.close()

    def take(self, speed: float) -> Robot:
        """Return a chassis in its initial state, at this speed."""
        robot, self._free = self._free, None
        if robot is None:
            robot = Robot(SimulatedChassis(**self._options).start())
        robot.renew(speed)
        return robot

    def give_back(self, robot: Robot) -> None:
        """Keep it for the next test, or close it if its graph has changed."""
        if self._free is None and robot.is_sound():
            robot.sim.speed = 0.0  # its world stands, and costs nothing, until it is taken
            self._free = robot
        else:
            robot.sim.close()


class Robot:
    """A simulated chassis, and the initial state of its graph.

    Attributes:
        sim: The chassis.
    """

    def __init__(self, sim: SimulatedChassis) -> None:
        self.sim = sim
        assert sim._master is not None
        self._master, self._epoch = sim._master, sim._epoch
        self._servers = [s for s in sim.graph._keep if isinstance(s, rosproto.ActionServer)]
        _eventually(lambda: self._graph() == self._graph())
        self._state, self._links, self._services = self._graph(), self._connections(), self._provided()
        self._listened = self._heard()

    def _graph(self) -> object:
        with rosproto.MasterClient(self._master.uri, "/pool") as client:
            state = client.get_system_state()
            names = [{name: sorted(nodes) for name, nodes in group.items()} for group in state]
            return names, sorted(client.get_param_names())

    def _connections(self) -> dict[tuple[str, str], int]:
        return {key: publisher.connections for key, publisher in self.sim.graph.publishers.items()}

    def _heard(self) -> list[int]:
        """How many send it commands: one that is still connected may have sent one that is not read yet."""
        return [kept.connections for kept in self.sim.graph._keep if isinstance(kept, rosproto.Subscriber)]

    def _provided(self) -> list[object]:
        """The service servers: another one of the same name looks the same to the master."""
        return [
            kept[0]
            for node in self.sim.graph.nodes.values()
            for kept in node._parts.services._servers.values()
        ]

    def renew(self, speed: float) -> None:
        """Power the robot up again in the same graph."""
        sim, world = self.sim, self.sim.world
        with sim.lock:
            world._power_up()
            world.take_reports()
            # A latched state is said anew: the last one said is that of the world before.
            sim._status, sim._plan, sim._epoch = None if sim._latch else world.status(), [], self._epoch
            sim.speed, sim.reply_delay = speed, 0.0
            sim.network._silent_until = 0.0
            sim.graph.heard.clear()
            sim.lock.wait_for(lambda: sim._status is not None, PATIENCE)
        for server in self._servers:
            with server._lock:
                server._goals = GoalList()
            server._publish_status()

    def is_sound(self) -> bool:
        """Whether it is in the initial state for the next test."""
        sim = self.sim
        if sim._master is not self._master or sim.closing or sim.network._down_until or sim.network.delay:
            return False
        with sim.lock:
            sim.world.press_emergency_stop()  # ends whatever moves
            sim.speed = 50.0  # ends whatever takes its time
        return _eventually(
            lambda: (
                not any(server._workers for server in self._servers)
                and self._provided() == self._services
                and self._connections() == self._links
                and self._heard() == self._listened
                and not sim.network._queue  # what was under way when a slow network became quick again
                and self._graph() == self._state
            )
        )


def _eventually(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            if condition():
                return True
        except RosError:
            return False
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
