"""The state that the parts of one application share: robots, access rules, clients, slots, threads, hubs."""

from __future__ import annotations

from collections.abc import Mapping

from rosproto.admission import ConnectionSlots
from rosproto.aio import Pool
from woosh_pure.lease import DEFAULT_SECONDS
from woosh_pure.web.access import LEFT_SESSIONS, AccessRules, Clients
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.live.hub import Hub
from woosh_pure.web.robot import Robot

OTHER_CONNECTIONS, RESERVED_CONNECTIONS, MAX_PER_ADDRESS = 192, 64, 64
"""Connections besides those of viewers; those reserved for known addresses; and how many an unknown address
can have."""
SILENT_SECONDS = 10.0
"""Seconds allowed before the first request, and between requests."""


class WebContext:
    """The state that the parts of one application share.

    Attributes:
        robots: By name. Paths without a robot's name mean the first one.
        access: The access rules.
        allow_driving: Whether a page may drive by velocity.
        clients: Pages and their sessions.
        slots: The slots for connections. Unused if the application is mounted in another server.
        drives, reads: Threads for each of these purposes.
        hubs: The hub of each robot, by its name.
        max_viewers: The most viewers at a time.
        streams, viewers: Numbers of open ones.
        closed: True once the server is ending.
    """

    def __init__(
        self, robots: Mapping[str, Robot], access: AccessRules, *, allow_driving: bool, max_viewers: int
    ) -> None:
        self.robots, self.access, self.allow_driving = dict(robots), access, allow_driving
        self.max_viewers = max_viewers
        self.clients = Clients(max_viewers + LEFT_SESSIONS)
        self.slots = ConnectionSlots(
            max_viewers + OTHER_CONNECTIONS,
            reserved=RESERVED_CONNECTIONS,
            max_per_address=MAX_PER_ADDRESS,
            max_silence=SILENT_SECONDS,
        )
        # Not daemons: a program that ends still sends the zeros of its drives.
        self.drives, self.reads = (
            Pool(8, name=f"woosh:web {work}", daemon=False, idle_seconds=0.5) for work in ("drive", "read")
        )
        self.hubs = {name: Hub(robot, self.reads) for name, robot in self.robots.items()}
        self.streams = 0
        self.viewers = 0
        self.closed = False

    def robot(self, name: str | None) -> Robot:
        """The robot with that name; the first one for None.

        Raises:
            Problem: There is no robot with that name.
        """
        if name is None:
            return next(iter(self.robots.values()))
        if name not in self.robots:
            text = "there is no robot {name!r}; there are {names}"
            raise Problem(404, text, name=name[:40], names=", ".join(self.robots))
        return self.robots[name]

    def take_over(self, robot: Robot, who: str, seconds: float = DEFAULT_SECONDS) -> None:
        """Give a program's lease to a client that has requested it; a program cannot grant its lease.

        Raises:
            Problem: A page has the lease, or the client has not requested it.
        """
        lease = robot.chassis.lease
        holder = lease.holder
        if holder in (None, who):
            lease.acquire(who, seconds)
            return
        assert holder is not None
        if self.clients.is_page(holder):
            raise Problem(
                409, "{holder} is a person, who has to agree; ask for the lease", "lease", holder=holder
            )
        if not lease.take_over(who, holder, seconds):
            text = "ask {holder} for the lease first; who asks a program twice may take it over"
            raise Problem(409, text, "lease", holder=holder)
        robot.journal.note(who, command("take_over", holder=holder))

    def close(self, why: str) -> None:
        """End driving by velocity at once. Requests that are still waiting end soon."""
        self.closed = True
        for robot in self.robots.values():
            robot.close(why)
        for workers in (self.drives, self.reads):
            workers.close()
