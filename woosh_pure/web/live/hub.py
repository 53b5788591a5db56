"""The content for all viewers of one robot: the newest of each kind, encoded once, with a version.

The hub runs in the event loop of the application while there are viewers, and asks the robot in threads. A
viewer remembers the last version that it was sent, so a slow viewer takes no more memory.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, ParamSpec, TypeVar

from rosproto.aio import Pool
from rosproto.errors import RosError
from rosproto.logs import get_logger
from rosproto.sentence import say
from woosh_pure.feed.feed import Reading
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import grid_from_message
from woosh_pure.maps.marks import UserMark
from woosh_pure.values.state import LaserScan
from woosh_pure.web.camera import SharedFeed, jpeg_of
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.live import robot_state
from woosh_pure.web.live.frames import camera_frame, costmap_frames, scan_frame
from woosh_pure.web.marks import mark_part
from woosh_pure.web.robot import ALSO_SHOWN, Robot
from woosh_pure.web.robot_site import SiteFacts
from woosh_pure.web.snapshot import NewestReadings, ages, points_part, pose_part, state_parts, text_of

P = ParamSpec("P")
T = TypeVar("T")
Content = str | bytes | tuple[bytes, ...]
_logger = get_logger("woosh_pure.web")
TICK, SLOW, PICTURE_EVERY, SCAN_EVERY, MAP_EVERY = 0.05, 0.4, 0.2, 0.1, 5.0
LOST_AFTER = 1.5
"""A robot counts as lost after this time without a message; a running chassis sends many a second."""
STATE_PARTS = (
    *("status", "battery", "velocity", "odometer"),
    *("readiness", "faults", "goals", "recordings", "missions", "activity", "rates"),
)


async def _keep_running(loop: Callable[[], Awaitable[None]]) -> None:
    """Run a loop while there are viewers. After an unexpected error, log it and start the loop again."""
    while True:
        try:
            await loop()
        except Exception:
            _logger.exception("! a look at the robot failed")
            await asyncio.sleep(1.0)


def _encoded(what: str, value: Any) -> Content:
    """Encode a picture of a camera, or the costmap in its parts."""
    if what != "costmap":
        return camera_frame(what, jpeg_of(value))
    grid = grid_from_message(value)
    return costmap_frames(grid.cells, grid.resolution, grid.origin)


class Hub:
    """The hub of one robot. Used in the event loop only; it calls the robot in threads.

    Attributes:
        newest: Version and content of each kind: text or bytes, or the parts of the costmap.
    """

    def __init__(self, robot: Robot, workers: Pool) -> None:
        self.robot, self._workers = robot, workers
        self.newest: dict[str, tuple[int, Content]] = {}
        self._viewers: set[Callable[[], None]] = set()
        self._version = 0
        self._tasks: list[asyncio.Task[None]] = []
        self._pictures: dict[str, SharedFeed[Any]] = {**robot.cameras, "costmap": robot.costmap}
        self._watched = dict.fromkeys(self._pictures, 0)
        self._seen: dict[str, float] = {}
        self._failed: set[str] = set()  # parts that could not be shown; logged once
        self._counts: deque[tuple[float, dict[str, int]]] = deque(maxlen=60)
        self._mounting: tuple[tuple[str, int], robot_state.Mounting] | None = None

    # -- viewers ---------------------------------------------------------------------------------------------

    def join(self, wake: Callable[[], None]) -> None:
        """Add a viewer; its `wake()` is called when something is new."""
        self._viewers.add(wake)
        if not self._tasks:
            pictures = [partial(self._picture_loop, what) for what in self._pictures]
            loops: list[Callable[[], Awaitable[None]]] = [
                self._fast_loop,
                self._slow_loop,
                self._map_loop,
                *pictures,
            ]
            self._tasks = [asyncio.ensure_future(_keep_running(loop)) for loop in loops]

    def leave(self, wake: Callable[[], None]) -> None:
        """Remove a viewer. After the last one, all loops end."""
        self._viewers.discard(wake)
        if not self._viewers:
            tasks, self._tasks = self._tasks, []
            for task in tasks:
                task.cancel()
            self.newest.clear()  # the next viewer must not get old values first
            self._seen.clear()
            for shared in self._pictures.values():
                self._workers.start(shared.close_idle, 0.0)

    async def watch(self, what: str, on: bool) -> None:
        """Count a viewer of "color", "depth" or "costmap" in or out."""
        self._watched[what] = max(0, self._watched[what] + (1 if on else -1))
        shared = self._pictures[what]
        await self._in_thread(shared.add_viewer if on else shared.remove_viewer, asks_robot=False)
        if not self._watched[what]:
            self.newest.pop(what, None)
            self._seen.pop(what, None)  # a latched value is shown again to the next viewer

    def put(self, kind: str, content: Content, *, again: bool = False) -> None:
        """Set the content of a kind. Equal content gets no new version, unless `again` is true."""
        before = self.newest.get(kind)
        if not again and before is not None and before[1] == content:
            return
        self._version += 1
        self.newest[kind] = (self._version, content)

    def wake(self) -> None:
        """Wake all viewers."""
        for wake in list(self._viewers):
            wake()

    # -- loops -----------------------------------------------------------------------------------------------

    async def _fast_loop(self) -> None:
        """Read the newest values of the feeds many times a second."""
        robot, due, shown = self.robot, 0.0, 0
        while robot.unreachable:
            self._go_on(self._not_connected)
            self.wake()
            await asyncio.sleep(SLOW)
        self._seen.pop("began", None)  # the time of silence counts from here
        await self._in_thread(robot.listen)
        while True:
            now = time.monotonic()
            readings = robot.readings()
            self._go_on(self._state, readings)
            self._go_on(self._pose, readings["pose"])
            await self._scan()
            if now >= due:
                due = now + 0.5
                self._go_on(self._ages, readings, now)
            self._go_on(self._check_silence, now)
            if self._version != shown:  # also by another loop
                shown = self._version
                self.wake()
            await asyncio.sleep(TICK)

    def _go_on(self, show: Callable[P, None], *values: P.args, **more: P.kwargs) -> None:
        """Show one part. Log a failure once, and go on with the others."""
        try:
            show(*values, **more)
        except Exception:
            if show.__name__ not in self._failed:
                self._failed.add(show.__name__)
                _logger.exception("! %s: a part of its state cannot be shown", self.robot.name)

    async def _slow_loop(self) -> None:
        """Request the slower parts in a thread, a few times a second."""
        robot = self.robot
        shown: list[UserMark] | None = None
        named: SiteFacts | None = None
        while True:
            if (site := robot.site.known()) is not named:
                named = site
                outline = points_part(site.outline.points if site.outline else ())
                self.put("site", text_of({"t": "site", **site.as_json(), "outline": outline}))
            marks = await self._in_thread(robot.all_marks, asks_robot=False)
            if marks is not None and marks != shown:
                shown = marks
                self.put("marks", text_of({"t": "marks", "marks": [mark_part(mark) for mark in marks]}))
            await self._in_thread(robot.listen)  # again, in case the robot was not connected yet
            parts = await self._in_thread(lambda: robot_state.slow_parts(robot))
            for part, value in (parts or {}).items():
                self.put(part, text_of(value))
            points = await self._in_thread(lambda: robot_state.path_points(robot))
            if points is not None:
                self.put("plan", text_of({"t": "plan", "points": points}))
            if robot.simulator is not None:
                circles = robot.simulator.world.obstacles
                self.put("obstacles", text_of({"t": "obstacles", "circles": circles}))
            for shared in self._pictures.values():
                await self._in_thread(shared.close_idle)
            await asyncio.sleep(SLOW)

    async def _map_loop(self) -> None:
        while True:
            known = await self._in_thread(self.robot.map.get)
            if known is not None:
                self.put("map", text_of({"t": "map", **known.as_json()}))
            await asyncio.sleep(MAP_EVERY)

    async def _picture_loop(self, what: str) -> None:
        shared = self._pictures[what]
        while True:
            reading = shared.newest() if self._watched[what] else None
            if reading is not None and self._is_new(what, reading.received):
                content = await self._in_thread(partial(_encoded, what, reading.value))
                if content is not None and self._watched[what]:
                    self.put(what, content, again=True)
            await asyncio.sleep(PICTURE_EVERY)

    async def _in_thread(self, ask: Callable[[], T], *, asks_robot: bool = True) -> T | None:
        """Call in a thread; None without an answer. The page shows the age of its values."""
        if asks_robot and self.robot.unreachable:
            return None  # no thread waits for it
        try:
            return await self._workers.start(ask)
        except (RosError, ValueError, Problem) as error:
            _logger.debug("! %s: %s", self.robot.name, error)
            return None
        except Exception:
            _logger.exception("! %s: a look at the robot failed", self.robot.name)
            return None

    # -- parts -----------------------------------------------------------------------------------------------

    def _state(self, readings: NewestReadings) -> None:
        for part, value in state_parts(readings).items():
            self.put(part, text_of(value))

    def _pose(self, reading: Reading[Pose2D] | None) -> None:
        part = None if reading is None else pose_part(reading.value)
        if reading is not None and part is not None and self._is_new("pose", reading.received):
            self.put("pose", text_of({"t": "pose", **part, "age": round(reading.age, 2)}))

    def _show_scan(self, value: LaserScan, mounting: robot_state.Mounting, pose: Pose2D) -> None:
        angles, at = mounting.angles(value), mounting.pose
        if all(map(math.isfinite, (*angles, pose.x, pose.y, pose.yaw, at.x, at.y, at.yaw))):
            place = pose.transformed(at.x, at.y, at.yaw)
            self.put("scan", scan_frame(value.ranges, (value.range_min, value.range_max), angles, place))

    def _is_new(self, what: str, received: float) -> bool:
        if self._seen.get(what) == received:
            return False
        self._seen[what] = received
        return True

    async def _scan(self) -> None:
        scan, pose = self.robot.feed("scan").known, self.robot.feed("pose").known
        if scan is None or pose is None:
            return
        # 0.9: of scans at that very rate, one that comes a little early is shown too.
        if scan.received - self._seen.get("scan", 0.0) < SCAN_EVERY * 0.9:
            return
        self._seen["scan"] = scan.received
        value = scan.value
        mounted_by = (value.frame, self.robot.feed("tf_static").count)
        if self._mounting is None or self._mounting[0] != mounted_by:
            mounted = await self._in_thread(partial(robot_state.laser_mounting, self.robot, value))
            if mounted is None:
                return
            self._mounting = (mounted_by, mounted)
        self._go_on(self._show_scan, value, self._mounting[1], pose.value)

    def _ages(self, readings: NewestReadings, now: float) -> None:
        scan = self.robot.feed("scan").known
        self.put("ages", text_of({**ages(readings), **ages({"scan": scan})}))
        names = (*readings, "scan")
        self._counts.append((now, {name: self.robot.feed(name).count for name in names}))
        while len(self._counts) > 2 and now - self._counts[0][0] > 3.0:
            self._counts.popleft()
        then, before = self._counts[0]
        if now - then > 0.9:
            counts = self._counts[-1][1]
            rates = {name: round((counts[name] - before[name]) / (now - then), 1) for name in names}
            self.put("rates", text_of(rates))

    def _not_connected(self) -> None:
        began = self._seen.setdefault("began", time.monotonic())
        text = str(say("not connected to the robot yet: {why}", why=self.robot.unreachable))
        since = round(time.monotonic() - began)
        self.put("lost", text_of({"t": "lost", "text": text, "since": since, "key": "not-connected"}))

    def _check_silence(self, now: float) -> None:
        heard = [
            r.received for r in (self.robot.feed(n).known for n in (*ALSO_SHOWN, "velocity", "pose")) if r
        ]
        began = self._seen.setdefault("began", now)
        since = now - max(heard, default=began)
        document: dict[str, object] = {"t": "lost", "text": None, "since": 0.0, "key": "silent"}
        if since > LOST_AFTER:
            begun = f"for {since:.0f} s" if heard else "so far"
            document["text"] = f"nothing was heard of the robot {begun}: what is shown is old; look at it"
            document["since"] = round(since)
        self.put("lost", text_of(document))
