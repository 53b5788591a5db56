"""The navigation's costmap, subscribed only while somebody looks at it. Not every chassis publishes it."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.maps.gridmap_message import grid_from_message
from woosh_pure.web.live.frames import costmap_frames

if TYPE_CHECKING:
    import rosproto
    from woosh_pure.web.robot import Robot

__all__ = ["TOPIC", "Costmap"]

TOPIC = "/move_base/global_costmap/costmap"
"""move_base's name for it. The vendor's page does not list it, so this is an assumption."""
_logger = get_logger("woosh_pure.web")


class Costmap:
    """The subscription of the costmap, and its newest message. Safe from any thread."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lock = threading.Lock()
        self._subscriber: rosproto.Subscriber | None = None
        self._newest: Any = None
        self._framed: tuple[Any, tuple[bytes, ...] | None] = (None, None)

    def set_wanted(self, on: bool) -> None:
        """Subscribe, or end the subscription."""
        with self._lock:
            if on and self._subscriber is None:
                self._subscriber = self._robot.chassis.node.subscriber(
                    TOPIC, "nav_msgs/OccupancyGrid", callback=self._take, queue_size=1
                )
            elif not on and self._subscriber is not None:
                self._subscriber.close()
                self._subscriber = self._newest = None

    def _take(self, message: Any) -> None:
        self._newest = message

    def frames(self) -> tuple[bytes, ...] | None:
        """The newest costmap as frames; None if there is none. Each message is encoded once."""
        message = self._newest
        if message is not self._framed[0]:
            self._framed = message, self._encode(message)
        return self._framed[1]

    def _encode(self, message: Any) -> tuple[bytes, ...] | None:
        if message is None:
            return None
        try:
            grid = grid_from_message(message)
            return costmap_frames(grid.cells, grid.resolution, grid.origin)
        except (ValueError, RosError) as error:
            _logger.warning("! %s: %s", TOPIC, error)
            return None
