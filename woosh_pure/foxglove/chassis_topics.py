"""`ChassisTopics`: the overlay and the map as topics for viewers, made only while a viewer subscribes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from msgdefs.nav_msgs.msg import OccupancyGrid
from msgdefs.visualization_msgs.msg import MarkerArray
from rosproto.errors import RosError
from rosproto.gateway import LocalTopic
from rosproto.logs import get_logger
from woosh_pure.chassis import Chassis
from woosh_pure.foxglove.overlay import Overlay, OverlayState
from woosh_pure.interface.table import row
from woosh_pure.maps.marks import UserMark

__all__ = ["MAP", "OVERLAY", "ChassisTopics"]

_log = get_logger("woosh_pure.foxglove")

OVERLAY, MAP = "/woosh/overlay", "/woosh/map"
OVERLAY_PERIOD = 0.5  # s
MAP_PERIOD = 60.0  # s: a service call with megabytes
AFTER_AN_ERROR = 5.0  # s
MAP_SECONDS = 30.0  # for the call
OLD = 3.0  # s: older poses are marked as old


class ChassisTopics:
    """`/woosh/overlay` and `/woosh/map` for a `Foxglove`; only reads from the chassis.

    Args:
        chassis: The chassis to show.
        marks: Returns your marks; called for every drawing.
        language: "en" or "zh", for the texts of faults.
    """

    def __init__(
        self,
        chassis: Chassis,
        marks: Callable[[], Sequence[UserMark]] = tuple,
        language: str = "en",
    ) -> None:
        self._chassis = chassis
        self._marks = marks
        self._overlay = Overlay(language)
        self._map_data = b""
        self._drawer = _Repeated("overlay", OVERLAY_PERIOD, self._draw)
        self._mapper = _Repeated("map", MAP_PERIOD, self._fetch)
        self.overlay = LocalTopic(OVERLAY, MarkerArray, self._drawer.run)
        self.map = LocalTopic(MAP, OccupancyGrid, self._mapper.run)

    @property
    def all(self) -> tuple[LocalTopic, ...]:
        """Both topics, for `Foxglove(topics=...)`."""
        return (self.overlay, self.map)

    def state(self) -> OverlayState:
        """The state for the overlay now."""
        chassis = self._chassis
        where = chassis.pose.reading
        return OverlayState(
            pose=None if where is None else where.value,
            status=chassis.status.latest,
            battery=chassis.battery.latest,
            faults=chassis.faults,
            marks=self._marks(),
            old=None if where is None or where.age < OLD else where.age,
        )

    def _draw(self) -> None:
        now = self._chassis.node.clock.now()
        self.overlay.publish(self._overlay.markers(self.state(), now), now)

    def _fetch(self) -> None:
        service = row("/aic_map_server/get_map")
        with self._chassis.node.service_client(service.name, service.type) as client:
            grid = client.call(timeout=MAP_SECONDS).map
        data = bytes(grid.data)
        if data != self._map_data:
            self._map_data = data
            self.map.publish(grid)

    def close(self) -> None:
        """Stop publishing. May be called again."""
        self._drawer.close()
        self._mapper.close()

    def __enter__(self) -> ChassisTopics:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()


class _Repeated:
    """Calls a function periodically while its result is wanted, in its own thread.

    Args:
        name: For the thread and the log.
        period: Seconds between two calls.
        work: The function; an error of ROS is logged, and the call repeated.
    """

    def __init__(self, name: str, period: float, work: Callable[[], object]) -> None:
        self._name = name
        self._period = period
        self._work = work
        self._lock = threading.Lock()
        self._stop: threading.Event | None = None
        self._thread: threading.Thread | None = None
        self._closed = False

    def run(self, wanted: bool) -> None:
        """Start or stop the calls."""
        with self._lock:
            if self._stop is not None:
                self._stop.set()
                self._stop = None
            if wanted and not self._closed:
                self._stop = threading.Event()
                self._thread = threading.Thread(
                    target=self._loop, args=(self._stop,), name=f"woosh:{self._name}", daemon=True
                )
                self._thread.start()

    def _loop(self, stop: threading.Event) -> None:
        logged = ""
        wait = 0.0
        while not stop.wait(wait):
            try:
                self._work()
                wait, logged = self._period, ""
            except (RosError, OSError, ValueError) as problem:
                if str(problem) != logged:
                    _log.warning("! foxglove: the %s cannot be shown now: %s", self._name, problem)
                logged, wait = str(problem), AFTER_AN_ERROR

    def close(self) -> None:
        with self._lock:
            self._closed = True
        self.run(False)
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)
