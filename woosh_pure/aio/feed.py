"""Feeds in asyncio: `async for pose in robot.pose`, `await robot.battery`."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Generator
from typing import Any, Generic, TypeVar

from rosproto.aio import Mailbox, SameProperty
from rosproto.errors import ConnectionLost, RosError
from rosproto.logs import get_logger
from rosproto.transport import Deadline
from woosh_pure import readings, values
from woosh_pure.aio.calls import ThreadCalls, in_loop
from woosh_pure.connection.arguments import require_timeout
from woosh_pure.faults import StatusCode
from woosh_pure.feed import feed
from woosh_pure.feed.feed import FIRST_USE, Newest, Reading
from woosh_pure.feed.feed import Feed as Threaded
from woosh_pure.geometry import Pose2D, Velocity

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
        row: The row of the interface table.
    """

    def __init__(self, feed: feed.Feed[T], calls: ThreadCalls) -> None:
        self.feed = feed
        self.row = feed.row
        self._calls = calls

    def __repr__(self) -> str:
        return f"<aio {repr(self.feed)[1:]}"

    topic = SameProperty[str](Threaded.topic, "feed")

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

    known = SameProperty[Reading[T] | None](Threaded.known, "feed")

    @property
    def reading(self) -> Reading[T] | None:
        """The newest reading, None when nothing was heard yet."""
        if not self.feed.opened:
            self._calls.spawn(self._subscribe)
        return self.feed.known

    def _subscribe(self) -> None:
        try:
            self.feed.open()
        except RosError as error:  # raised by `wait` instead
            logger.debug("! %s: not subscribed: %s", self.topic, error)

    count = SameProperty[int](Threaded.count, "feed")
    sources = SameProperty[frozenset[str]](Threaded.sources, "feed")

    @property
    def history(self) -> tuple[Reading[T], ...]:
        """The last readings, oldest first: 100 of them, or 3 for pictures and point clouds."""
        return self.feed.known_history if self.reading is not None else ()

    @property
    def publishers(self) -> int:
        """Publishers connected now."""
        return self.feed.publishers if self.feed.opened else 0

    errors = SameProperty[list[Exception]](Threaded.errors, "feed")
    unreachable = SameProperty[str](Threaded.unreachable, "feed")
    outdated = SameProperty[bool](Threaded.outdated, "feed")
    closed = SameProperty[bool](Threaded.closed, "feed")

    # -- waiting

    async def on(self, callback: Callable[[T], object]) -> Callable[[], None]:
        """Call `callback(value)` in this loop for each new value; returns a function that ends it.

        Raises:
            ConnectionLost: The Chassis is closed.
        """
        called = in_loop(callback)
        return await self._calls.opened(lambda: self.feed.on(called), lambda off: off())

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


class _FeedProperty(SameProperty[Feed[T]], Generic[T]):
    """The feed of the same name, awaited."""

    def __init__(self, of: Callable[[Any], Threaded[T]]) -> None:
        super().__init__(of, "chassis", lambda robot, feed: Feed(feed, robot._calls))


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
        return Feed(self.chassis.feed(name), self._calls)

    status = _FeedProperty[values.RobotStatus](readings.Readings.status)
    pose = _FeedProperty[Pose2D](readings.Readings.pose)
    odometer = _FeedProperty[float](readings.Readings.odometer)
    battery = _FeedProperty[values.Battery](readings.Readings.battery)
    localization = _FeedProperty[values.PoseEstimate](readings.Readings.localization)
    information = _FeedProperty[values.Information](readings.Readings.information)
    bms = _FeedProperty[values.Bms](readings.Readings.bms)
    parameters = _FeedProperty[values.Parameters](readings.Readings.parameters)
    measured_velocity = _FeedProperty[Velocity](readings.Readings.measured_velocity)
    status_code = _FeedProperty[StatusCode](readings.Readings.status_code)
    scan = _FeedProperty[values.LaserScan](readings.Readings.scan)
    imu = _FeedProperty[values.Imu](readings.Readings.imu)
    odometry_raw = _FeedProperty[values.Odometry](readings.Readings.odometry_raw)
    odometry = _FeedProperty[values.Odometry](readings.Readings.odometry)
    camera = _FeedProperty[values.Image](readings.Readings.camera)
    depth = _FeedProperty[values.Image](readings.Readings.depth)
    points = _FeedProperty[values.PointCloud](readings.Readings.points)
    obstacle_points = _FeedProperty[values.PointCloud](readings.Readings.obstacle_points)
