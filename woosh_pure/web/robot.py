"""One robot of the web server: its Chassis, and what all its viewers share."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from woosh_pure.web.camera import FEEDS, SharedCamera
from woosh_pure.web.goals import GoalManager
from woosh_pure.web.journal import Journal
from woosh_pure.web.live.teleop import Teleop
from woosh_pure.web.maps import MapCache, WebMark, marks_of
from woosh_pure.web.problems import Problem
from woosh_pure.web.recordings import RecordingManager
from woosh_pure.web.snapshot import LISTENED

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.feed.feed import Feed, Reading
    from woosh_pure.stopping.report import StopReport
    from woosh_pure.web.clients import Client

ALSO_SHOWN = ("scan", "plan", "tf_static")
__all__ = ["Robot"]


class _Stop:
    """A stop under way, and its result."""

    def __init__(self) -> None:
        self.over = threading.Event()
        self.report: StopReport | None = None


class Robot:
    """Opens and subscribes nothing until there is a request.

    Attributes:
        name: The robot's name in the paths of the API.
        chassis: The Chassis; whoever made it opens and closes it.
        marks: The marks that were given: the chassis cannot list its own.
        journal, goals, teleop, map, cameras, recordings: See the classes of the same names.
    """

    def __init__(
        self,
        name: str,
        chassis: Chassis,
        *,
        marks: Iterable[Any] = (),
        recordings: Path | None = None,
    ) -> None:
        self.name, self.chassis = name, chassis
        self.marks: tuple[WebMark, ...] = marks_of(marks)
        self.journal = Journal()
        self.goals = GoalManager(self.journal)
        self.teleop = Teleop(chassis)
        self.map = MapCache(chassis)
        self.cameras = {source: SharedCamera(chassis, source) for source in FEEDS}
        self.recordings = RecordingManager(chassis, recordings)
        self._listening = False
        self._lock = threading.Lock()
        self._stopping: dict[bool, _Stop] = {}

    def listen(self) -> None:
        """Subscribe to what the snapshot needs. Blocks the first time, until the links are connected."""
        if self._listening:
            return
        names = (*LISTENED, *ALSO_SHOWN)
        for name in names:
            self.feed(name).open()
        self.chassis.readiness()
        for name in names:
            self.feed(name).connect()
        self._listening = True

    def feed(self, name: str) -> Feed[Any]:
        """A feed of the chassis."""
        return self.chassis.feed(name)

    def readings(self) -> dict[str, Reading[Any] | None]:
        """The newest values for the snapshot. Never waits."""
        return {name: self.feed(name).known for name in LISTENED}

    def require_lease(self, client: Client) -> None:
        """Refuse a command while another client has the lease.

        Raises:
            Problem: Another client has the lease.
        """
        lease = self.chassis.lease
        holder = lease.holder
        if holder is not None and holder != client.name:
            raise Problem(
                409,
                f"{holder} commands this robot now; ask for the lease, and wait until it is granted",
                "leased",
                holder=holder,
            )
        if holder is not None:
            lease.renew(client.name)

    def stop(self, who: str, *, everything: bool = True, timeout: float = 5.0) -> StopReport:
        """Stop now; blocks until it is known whether the robot stands still. Requests to stop that arrive
        meanwhile get the same answer.
        """
        self.teleop.halt(f"{who} stopped the robot")
        with self._lock:
            stop = self._stopping.get(everything)
            begins = stop is None
            if stop is None:
                stop = self._stopping[everything] = _Stop()
        if begins:
            self._stop(stop, who, everything, timeout)
        stop.over.wait(timeout + 25.0)
        if stop.report is None:
            raise Problem(504, "the stop was sent, but is not confirmed: watch the robot, use its own button")
        return stop.report

    def _stop(self, stop: _Stop, who: str, everything: bool, timeout: float) -> None:
        entry = self.journal.begin(who, "stop")
        try:
            stop.report = report = self.chassis.stop(everything=everything, timeout=timeout)
            state = {True: "stands still", False: "STILL MOVES", None: "not known"}[report.standing]
            self.journal.end(entry, state, report.sentence())
        finally:
            with self._lock:
                del self._stopping[everything]
            stop.over.set()

    def close(self, why: str) -> None:
        """End driving and recordings at once. The Chassis is closed by whoever opened it."""
        self.teleop.close(why)
        self.recordings.close()
