"""Camera pictures as JPEG. Cameras and the costmap are subscribed only while they have viewers: they have the
highest data rates of all topics.
"""

from __future__ import annotations

import io
import threading
import time
from typing import Generic, TypeVar

import numpy as np

from woosh_pure import interface
from woosh_pure.chassis import Chassis
from woosh_pure.feed.feed import Feed, Reading
from woosh_pure.interface.schema import Row
from woosh_pure.values.state import Image
from woosh_pure.web.optional_libraries import pillow

T = TypeVar("T")
CAMERAS = {"color": interface.find("camera"), "depth": interface.find("depth")}
COSTMAP = Row(
    "/move_base/global_costmap/costmap",
    "nav_msgs/OccupancyGrid",
    "topic",
    "read",
    "the costmap of the navigation",
)
"""move_base's name for it. The vendor's page does not list it, so this is an assumption; not every chassis
publishes it."""
MAX_WIDTH, QUALITY = 640, 70
LINGER = 2.0
"""Seconds for which a feed stays subscribed after the last viewer, so that the next request is fast."""


def jpeg_of(image: Image, width: int = MAX_WIDTH) -> bytes:
    """The picture as JPEG, scaled down to at most that width."""
    pixels = image.visible()
    step = max(1, -(-pixels.shape[1] // width))
    small = np.ascontiguousarray(pixels[::step, ::step, :3] if pixels.ndim == 3 else pixels[::step, ::step])
    picture = pillow().fromarray(small)
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=QUALITY)
    return out.getvalue()


class SharedFeed(Generic[T]):
    """A feed with large messages of one robot: one subscription for all viewers. Safe from any thread."""

    def __init__(self, chassis: Chassis, row: Row) -> None:
        self._chassis, self._row = chassis, row
        self._lock = threading.Lock()
        self._feed: Feed[T] | None = None
        self._viewers = 0
        self._left = 0.0

    @property
    def open(self) -> bool:
        """Whether it is subscribed now."""
        return self._feed is not None

    def add_viewer(self) -> None:
        """Add a viewer. Blocks while it is being subscribed."""
        with self._lock:
            self._viewers += 1
            if self._feed is None:
                self._feed = Feed(self._row, lambda: self._chassis.node).open()

    def remove_viewer(self) -> None:
        """Remove a viewer. `close_idle` ends the subscription later."""
        with self._lock:
            self._viewers, self._left = max(0, self._viewers - 1), time.monotonic()

    def close_idle(self, linger: float = LINGER) -> None:
        """End the subscription if there has been no viewer for `linger` seconds."""
        with self._lock:
            if self._viewers or self._feed is None or time.monotonic() - self._left < linger:
                return
            feed, self._feed = self._feed, None
        feed.close()

    def newest(self) -> Reading[T] | None:
        """Return the newest reading, or None if there is none yet. Never waits."""
        feed = self._feed
        return None if feed is None else feed.known

    def value(self, timeout: float = 3.0) -> T:
        """Return one value; blocks until there is one.

        Raises:
            RosTimeout: Nothing came in time.
        """
        self.add_viewer()
        try:
            feed = self._feed
            assert feed is not None
            return feed.wait(timeout, new=False)
        finally:
            self.remove_viewer()
