"""One robot of the web server: its Chassis with its journal, goals, marks, map, cameras, recordings and
stops.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.codec import DynamicMessage
from rosproto.sentence import say
from woosh_pure.chassis import Chassis, components_of
from woosh_pure.feed.feed import Feed
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark, with_robot_marks
from woosh_pure.stopping.report import StopReport
from woosh_pure.values.state import Image
from woosh_pure.web import models
from woosh_pure.web.access import Client
from woosh_pure.web.camera import CAMERAS, COSTMAP, SharedFeed
from woosh_pure.web.goals import Goal, GoalManager, IdempotentAnswers, Journal, command
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.live.manual_drive import ManualDrive
from woosh_pure.web.maps import MapCache
from woosh_pure.web.marks import MarkList
from woosh_pure.web.missions import RobotMissions
from woosh_pure.web.recordings import RecordingManager
from woosh_pure.web.robot_site import RobotSite
from woosh_pure.web.snapshot import LISTENED, NewestReadings, pose_part

if TYPE_CHECKING:
    from woosh_pure.sim import SimulatedChassis

ALSO_SHOWN = ("scan", "plan", "tf_static")
STOP_SECONDS = 5.0
"""Seconds for which a stop checks whether the robot comes to rest."""


class StopQueue:
    """Carries out the stops of one robot, in threads that no request and no other robot uses.

    Each request is a separate stop, also during another one, so that it ends motions begun meanwhile. While
    `MAX_STOPS` stops are under way, further requests wait for one of them, and become one stop.

    Args:
        stop: Called as `stop(who, everything)`; stops, and reports whether the robot stands still.
    """

    MAX_STOPS = 8

    def __init__(self, stop: Callable[[str, bool], StopReport]) -> None:
        self._stop = stop
        self._lock = threading.Lock()  # never held while waiting
        self._due: dict[bool, tuple[str, Future[StopReport]]] = {}
        self._under_way = 0

    def begin(self, who: str, everything: bool) -> Future[StopReport]:
        """Begin a stop without waiting. If no thread can be started, stop in this one."""
        with self._lock:
            if everything in self._due:
                return self._due[everything][1]
            future: Future[StopReport] = Future()
            future.set_running_or_notify_cancel()  # cancelling the wait does not end the stop
            self._due[everything] = who, future
            if self._under_way >= self.MAX_STOPS:
                return future
            self._under_way += 1
        try:
            threading.Thread(target=self._work, name="woosh:web stop", daemon=True).start()
        except RuntimeError:
            self._work()
        return future

    def _work(self) -> None:
        while True:
            with self._lock:
                if not self._due:
                    self._under_way -= 1
                    return
                everything, (who, future) = self._due.popitem()
            try:
                future.set_result(self._stop(who, everything))
            except Exception as error:
                future.set_exception(error)


class Robot:
    """One robot. It subscribes to nothing until there is a request.

    Attributes:
        name: The robot's name in the paths of the API.
        chassis: The Chassis; the caller opens and closes it.
        marks: The server's list of marks.
        site: What the robot itself names: marks, maps, zones, outline.
        journal, goals, idempotent_answers, manual_drive, map, cameras, costmap, recordings, missions: See
            their classes.
        simulator: The simulated chassis behind `chassis`; None for a real robot.
        unreachable: Why the Chassis is not connected yet; "" once it is.
    """

    def __init__(
        self,
        name: str,
        chassis: Chassis,
        *,
        marks: MarkList,
        recordings: Path | None = None,
        simulator: SimulatedChassis | None = None,
    ) -> None:
        self.name, self.chassis, self.marks, self.simulator = name, chassis, marks, simulator
        self.journal = Journal()
        self.goals = GoalManager(self.journal, chassis.readiness)
        self.idempotent_answers = IdempotentAnswers()
        self.manual_drive = ManualDrive(chassis)
        self.map = MapCache(chassis)
        self.site = RobotSite(chassis)
        self.cameras = {source: SharedFeed[Image](chassis, row) for source, row in CAMERAS.items()}
        self.costmap = SharedFeed[DynamicMessage](chassis, COSTMAP)
        self.recordings = RecordingManager(chassis, recordings)
        self.missions = RobotMissions(chassis, self.journal)
        self.unreachable = ""
        self._listening = False
        self._stops = StopQueue(self._stop)

    def listen(self) -> None:
        """Subscribe to the feeds of the snapshot. Blocks the first time, until the links are connected."""
        if self._listening:
            return
        names = (*LISTENED, *ALSO_SHOWN)
        for name in names:
            self.feed(name).open()
        self.chassis.readiness()
        for name in names:
            self.feed(name).connect()
        self._listening = True

    def require_connection(self) -> None:
        """Refuse a request while the robot is not connected yet, so that no thread waits for it.

        Raises:
            Problem: The robot has not been reached yet.
        """
        if self.unreachable:
            text = "not connected to the robot yet, as when it is switched off: {why}"
            raise Problem(503, text, "not-connected", why=self.unreachable)

    def all_marks(self, wait: float = 0.0) -> list[UserMark]:
        """The marks of the server's list and those of the robot; `wait` is that of `RobotSite.known`.

        Raises:
            Problem: The list cannot be read now.
        """
        return with_robot_marks(self.marks.all(), self.site.known(wait).marks)

    def find_mark(self, name: str) -> UserMark | None:
        """The mark of that name; None if there is none. Never waits for the robot."""
        return next((mark for mark in self.all_marks() if mark.name == name), None)

    def feed(self, name: str) -> Feed[Any]:
        """A feed of the chassis."""
        return self.chassis.feed(name)

    def readings(self) -> NewestReadings:
        """Return the newest values for the snapshot. Never waits."""
        return {name: self.feed(name).known for name in LISTENED}

    def require_lease(self, client: Client) -> None:
        """Refuse a command while another client has the lease.

        Raises:
            Problem: Another client has the lease.
        """
        lease = self.chassis.lease
        holder = lease.holder
        if holder is not None and holder != client.name:
            text = "{holder} commands this robot now; ask for the lease, and wait until it is granted"
            raise Problem(409, text, "leased", facts={"holder": "".join(holder)}, holder=holder)
        if holder is not None:
            lease.renew(client.name)

    def begin_stop(self, who: str, *, everything: bool = True) -> Future[StopReport]:
        """Begin a stop without waiting. An open drive has ended when this returns, and what was requested
        before cannot begin any more; the stop goes on.
        """
        why = say("{who} stopped the robot", who=who)
        self.manual_drive.halt(why)
        components_of(self.chassis).motions.note_stop(why)
        return self._stops.begin(who, everything)

    def _stop(self, who: str, everything: bool) -> StopReport:
        entry = self.journal.begin(who, command("stop" if everything else "stop_ours"))
        try:
            report = self.chassis.stop(everything=everything, timeout=STOP_SECONDS)
        except Exception as error:
            self.journal.end(entry, "failed", str(error))
            raise
        state = {True: "stands still", False: "STILL MOVES", None: "not known"}[report.standing]
        self.journal.end(entry, state, str(report))
        return report

    def begin_goal(self, body: models.GoalRequest, who: str, *, noted: bool = True) -> Goal:
        """Start a goal as a client describes it. To a mark that only this server's list has, it is a drive to
        the pose.

        Args:
            body: The goal.
            who: The client's name.
            noted: Whether the journal gets an entry for it.

        Raises:
            RosError, ValueError, Problem: See `GoalManager.begin`.
        """
        mark = self.find_mark(body.mark) if isinstance(body, models.AtMark) else None
        key = body.direction if isinstance(body, models.CarryGoal) else body.kind
        what = command(key, **body.model_dump(exclude={"kind", "direction", "timeout", "replace"}))
        reading, place = self.feed("pose").known, None if mark is None else mark.pose
        verb: Callable[[], models.MotionHandle] = partial(body.start, self.chassis)
        if mark is not None and place is not None and not mark.on_chassis:
            if not isinstance(body, models.MarkGoal):
                text = "{name} is a place of this list; the chassis itself must know a mark to {kind} there"
                raise Problem(409, text, "mark", name=mark.name, kind=body.kind)
            verb = partial(self.chassis.go_to, place.x, place.y, place.yaw, **body.options)
        if isinstance(body, models.PoseGoal):
            place = Pose2D(body.x, body.y)
        start = None if reading is None else pose_part(reading.value)
        target = None if place is None else pose_part(place)
        target = target and {"x": target["x"], "y": target["y"]}
        return self.goals.begin(body.kind, who, what, verb, start=start, target=target, noted=noted)

    def close(self, why: str) -> None:
        """End driving and recordings at once. The Chassis stays open."""
        self.manual_drive.close(why)
        self.recordings.close()
