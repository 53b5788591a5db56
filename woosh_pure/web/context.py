"""All robots of one application, who is connected, and the rules for them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from woosh_pure.web.clients import Clients
from woosh_pure.web.connection_slots import ConnectionSlots
from woosh_pure.web.live.hub import Hub
from woosh_pure.web.problems import Problem
from woosh_pure.web.workers import Workers

if TYPE_CHECKING:
    from woosh_pure.web.access import Access
    from woosh_pure.web.robot import Robot

__all__ = ["WebContext"]


class WebContext:
    """What the parts of one application share.

    Attributes:
        robots: By name; the first one is that of the plain paths.
        access: Who may ask.
        allow_driving: Whether a page may drive by velocity.
        clients: Who is connected.
        slots: The connections that the server has room for, where the server is ours.
        stops, drives, reads: Threads for each of these.
        hubs: What viewers are shown, by the robot's name.
        streams, viewers: How many are open.
        closed: The server ends.
    """

    def __init__(self, robots: Mapping[str, Robot], access: Access, *, allow_driving: bool) -> None:
        self.robots, self.access, self.allow_driving = dict(robots), access, allow_driving
        self.clients, self.slots = Clients(), ConnectionSlots()
        self.stops, self.drives = Workers("stop", 8), Workers("drive", 8)
        self.reads = Workers("read", 8)
        self.hubs = {name: Hub(robot, self.reads) for name, robot in self.robots.items()}
        self.streams = 0
        self.viewers = 0
        self.closed = False

    def robot(self, name: str | None) -> Robot:
        """A robot by its name, the first one for None.

        Raises:
            Problem: There is none of that name.
        """
        if name is None:
            return next(iter(self.robots.values()))
        if name not in self.robots:
            raise Problem(404, f"there is no robot {name[:40]!r}; there are {', '.join(self.robots)}")
        return self.robots[name]

    def close(self, why: str) -> None:
        """End what moves, at once; whoever waits for something here is told soon."""
        self.closed = True
        for robot in self.robots.values():
            robot.close(why)
        for workers in (self.stops, self.drives, self.reads):
            workers.close()
