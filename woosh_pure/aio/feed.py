"""Feeds in asyncio: `async for pose in robot.pose`, `await robot.battery`."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Generator
from typing import Any, Generic, TypeVar

from rosproto.aio import Mailbox, notify
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.transport import Deadline
from woosh_pure import readings, values
from woosh_pure.aio.calls import ThreadCalls
from woosh_pure.connection.arguments import require_timeout
from woosh_pure.faults import StatusCode
from woosh_pure.feed import feed
from woosh_pure.feed.feed import FIRST_USE, Newest, Reading
from woosh_pure.feed.feed import Feed as Threaded
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.interface.schema import Row

T = TypeVar("T")
logger = get_logger("woosh_pure.aio")
_LOOK_AGAIN = 0.2  # seconds; the end of a feed has no callback
_KEPT = 1000  # values kept for `wait_for`


class Feed(Newest[T]):
    """One topic the chassis publishes; as `woosh_pure.feed.Feed`, awaited.

    `await robot.battery` is the newest value, or the first one when none was received yet.
    `async for value in robot.pose` yields values as they come. Properties never wait: the first use of one
    starts the subscription, and before the first message it is None; `await feed.open()` waits for the links.

    Attributes:
        feed: The threaded one underneath.
    """

    def __init__(self, feed: feed.Feed[T], calls: ThreadCalls) -> None:
        self.feed = feed
        self._calls = calls

    def __repr__(self) -> str:
        return f"<aio {repr(self.feed)[1:]}"

    @property
    def row(self) -> Row:
        """The row of the interface table."""
        return self.feed.row

    @property
    def topic(self) -> str:
        """Name of the topic."""
        return self.feed.topic

    async def open(self) -> Feed[T]:
        """Subscribe now, and wait for the links as `wait_connected` does; returns this feed."""
        await self.wait_connected()
        return self

    async def wait_connected(self, timeout: float = FIRST_USE) -> bool:
        """Wait until each publisher the master lists is connected or has failed, latched values included.

        Returns:
            True when at least one publisher is connected.
        """
        return await self._calls.call(lambda: self.feed.wait_connected(timeout))

    # -- what was heard, without waiting

    @property
    def known(self) -> Reading[T] | None:
        """As `reading`, but neither subscribes nor waits; also None when this feed was never used."""
        return self.feed.known

    @property
    def reading(self) -> Reading[T] | None:
        """The newest reading, None when nothing was heard yet."""
        if not self.feed.opened:
            self._calls.let_go(self._subscribe)
        return self.feed.known

    def _subscribe(self) -> None:
        try:
            self.feed.open()
        except RosError as error:  # raised by `wait` instead
            logger.debug("! %s: not subscribed: %s", self.topic, error)

    @property
    def count(self) -> int:
        """Values received so far."""
        return self.feed.count

    @property
    def history(self) -> tuple[Reading[T], ...]:
        """The last readings, oldest first: 100 of them, or 3 for pictures and point clouds."""
        return self.feed.known_history if self.reading is not None else ()

    @property
    def publishers(self) -> int:
        """Publishers connected now."""
        return self.feed.publishers if self.feed.opened else 0

    @property
    def sources(self) -> frozenset[str]:
        """Addresses ("host:port") of the publishers connected now; a new address means a new process."""
        return self.feed.sources

    @property
    def errors(self) -> list[Exception]:
        """The last few errors on its links: refused by a publisher, connection lost ..."""
        return self.feed.errors

    @property
    def unreachable(self) -> str:
        """Why none of its publishers is connected although the master lists some; "" otherwise."""
        return self.feed.unreachable

    @property
    def outdated(self) -> bool:
        """True when the last value of a topic sent only on change may be out of date: its link has broken
        since, so a change may have been missed.
        """
        return self.feed.outdated

    @property
    def closed(self) -> bool:
        """True when nothing will come any more: the Chassis is closed, or its node is."""
        return self.feed.closed

    # -- waiting

    async def on(self, callback: Callable[[T], object]) -> Callable[[], None]:
        """Call `callback(value)` in this loop for each new value; returns a function that ends it.

        Raises:
            ConnectionLost: The Chassis is closed.
        """
        loop = asyncio.get_running_loop()
        return await self._calls.opened(
            lambda: self.feed.on(lambda value: notify(loop, callback, value)), lambda off: off()
        )

    async def wait(self, timeout: float | None = 5.0, *, new: bool = True) -> T:
        """The next value.

        Args:
            timeout: Seconds; None waits for ever.
            new: False returns a value at once when one was heard before.

        Raises:
            RosTimeout: None came in time.
            ConnectionLost: The Chassis is closed, or was closed meanwhile.
        """
        return await self._first(lambda value: True, timeout, new=new)

    async def wait_for(self, accept: Callable[[T], bool], timeout: float | None = 5.0) -> T:
        """The first value for which `accept`, called in this loop, is true: the newest one, or a later one.

        Raises:
            RosTimeout: None came in time.
            ConnectionLost: The Chassis is closed, or was closed meanwhile.
        """
        return await self._first(accept, timeout, new=False)

    def __await__(self) -> Generator[Any, None, T]:
        """The newest value, or the first one within 5 s: `wait(new=False)`."""
        return self.wait(new=False).__await__()

    async def _first(self, accept: Callable[[T], bool], timeout: float | None, *, new: bool) -> T:
        timeout = require_timeout(timeout)
        deadline = Deadline(timeout)
        async with _Values(self.feed, self._calls, _KEPT, known=not new) as values:
            while True:
                value = await values.next(deadline, timeout)
                if accept(value):
                    return value

    async def __aiter__(self) -> AsyncIterator[T]:
        """Values as they come; a slow loop skips to the newest. Ends when the chassis is closed, or its node.

        Raises:
            ConnectionLost: It was closed before, and nothing was ever received here; or there is no master.
        """
        may_end = not self.feed.closed or self.feed.known is not None
        try:
            async with _Values(self.feed, self._calls, 1, known=True) as values:
                while True:
                    yield await values.next(Deadline(None), None)
        except ConnectionLost:  # also when it was closed before the subscription was complete
            if not may_end or not self.feed.closed:
                raise


class _Values(Generic[T]):
    """Queue of a feed's values from now on, for this loop; ends with its block."""

    def __init__(self, feed: feed.Feed[T], calls: ThreadCalls, size: int, *, known: bool) -> None:
        self._feed = feed
        self._calls = calls
        self._known = known
        self._box: Mailbox[T] = Mailbox(size)

    async def __aenter__(self) -> _Values[T]:
        box = self._box
        reading = self._feed.known if self._known else None
        if reading is not None:
            box.put(reading.value)
        self._off = await self._calls.opened(lambda: self._feed.on(box.put, connect=False), lambda off: off())
        return self

    async def __aexit__(self, *exc_info: object) -> None:
        self._off()
        self._box.close()

    async def next(self, deadline: Deadline, timeout: float | None) -> T:
        """Return the next value; raises when none comes."""
        while True:
            left = deadline.remaining()
            try:
                if len(self._box):
                    return await self._box.get()
                return await self._box.get(_LOOK_AGAIN if left is None else min(left, _LOOK_AGAIN))
            except asyncio.TimeoutError:
                self._feed.require_open()
                if deadline.expired:
                    raise self._feed.silence(timeout) from None


# -- the feeds of the awaited `Chassis`: those of `woosh_pure.readings`, one by one, with their types --------


class Readings:
    """The part of the awaited `Chassis` that only listens; see there."""

    chassis: readings.Readings
    _calls: ThreadCalls

    def feed(self, name: str) -> Feed[Any]:
        """A feed by its name in the interface table or by its topic; works for every topic of the chassis.

        A topic without a property of its own yields the messages themselves.

        Raises:
            KeyError: It is not in the table; the text lists similar names.
            ValueError: It is not a topic that the chassis publishes.
        """
        return self._feed(self.chassis.feed(name))

    def _feed(self, feed: Threaded[T]) -> Feed[T]:
        return Feed(feed, self._calls)

    @property
    def status(self) -> Feed[values.RobotStatus]:
        """`/robot_status`, published on change only."""
        return self._feed(self.chassis.status)

    @property
    def pose(self) -> Feed[Pose2D]:
        """`/movebase_pose2d`: map_T_base, m and rad."""
        return self._feed(self.chassis.pose)

    @property
    def odometer(self) -> Feed[float]:
        """`/odometer`: metres travelled."""
        return self._feed(self.chassis.odometer)

    @property
    def battery(self) -> Feed[values.Battery]:
        """`/battery`: charge in %, voltage, current, temperatures, capacities; V, A, °C, Ah."""
        return self._feed(self.chassis.battery)

    @property
    def localization(self) -> Feed[values.PoseEstimate]:
        """`/amcl_pose`: the pose found by the localisation, with its covariance; m and rad in the map."""
        return self._feed(self.chassis.localization)

    @property
    def information(self) -> Feed[values.Information]:
        """`/information`: versions of the controller, type of the base, parameters."""
        return self._feed(self.chassis.information)

    @property
    def bms(self) -> Feed[values.Bms]:
        """`/driver_base/bms`: what the battery management system measures; V, A, °C, Ah."""
        return self._feed(self.chassis.bms)

    @property
    def parameters(self) -> Feed[values.Parameters]:
        """`/driver_base/parameter`: wheel geometry, reduction ratios, speed limits; m, m/s, rad/s."""
        return self._feed(self.chassis.parameters)

    @property
    def measured_velocity(self) -> Feed[Velocity]:
        """`/odom_twist`: how the base actually moves, m/s and rad/s."""
        return self._feed(self.chassis.measured_velocity)

    @property
    def status_code(self) -> Feed[StatusCode]:
        """`/status_code`, decoded; `faults` is the set that is active."""
        return self._feed(self.chassis.status_code)

    @property
    def scan(self) -> Feed[values.LaserScan]:
        """`/scan`: the fused lidar scan; m and rad in the scan's own frame."""
        return self._feed(self.chassis.scan)

    @property
    def imu(self) -> Feed[values.Imu]:
        """`/imu/data_raw`: raw inertial measurements; rad/s and m/s² in the IMU's frame."""
        return self._feed(self.chassis.imu)

    @property
    def odometry_raw(self) -> Feed[values.Odometry]:
        """`/odom_raw`: from the wheels alone."""
        return self._feed(self.chassis.odometry_raw)

    @property
    def odometry(self) -> Feed[values.Odometry]:
        """`/odom`: from wheels and IMU."""
        return self._feed(self.chassis.odometry)

    @property
    def camera(self) -> Feed[values.Image]:
        """`/camera_1/color/image_raw`: the colour image, as an array of pixels."""
        return self._feed(self.chassis.camera)

    @property
    def depth(self) -> Feed[values.Image]:
        """`/camera_1/depth/image_raw`: the depth image, as an array; m or mm, by its encoding."""
        return self._feed(self.chassis.depth)

    @property
    def points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/points`: the depth image as a point cloud; m in the camera's frame."""
        return self._feed(self.chassis.points)

    @property
    def obstacle_points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/cloud_without_planes`: points of obstacles, no ground; m, camera frame."""
        return self._feed(self.chassis.obstacle_points)
