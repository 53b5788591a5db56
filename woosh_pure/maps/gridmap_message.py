"""nav_msgs/OccupancyGrid to a `GridMap` and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosproto.sentence import say
from woosh_pure.geometry import quaternion_from_yaw
from woosh_pure.values.poses import pose_of
from woosh_pure.values.rostypes import message_type

if TYPE_CHECKING:
    from woosh_pure.maps.gridmap import GridMap

__all__ = ["grid_from_message", "grid_message"]


def grid_from_message(message: Any) -> GridMap:
    """The map of a message; the cells are a view of the message's memory where it allows that.

    Raises:
        ValueError: Fewer cells than the message says.
    """
    import numpy as np

    from woosh_pure.maps.gridmap import GridMap

    info = message.info
    cells = np.asarray(message.data, dtype=np.int8)
    if cells.size != info.width * info.height:
        raise ValueError(
            say(
                "map of {width} x {height} cells has {size}; the sender is wrong",
                width=info.width,
                height=info.height,
                size=cells.size,
            )
        )
    origin = pose_of(info.origin, message.header.frame_id or "map")
    return GridMap(cells.reshape(info.height, info.width), info.resolution, origin)


def grid_message(grid: GridMap, frame: str = "map") -> Any:
    """nav_msgs/OccupancyGrid of a map."""
    import numpy as np

    message = message_type("nav_msgs/OccupancyGrid")()
    message.header.frame_id = frame
    info = message.info
    info.resolution, info.width, info.height = grid.resolution, grid.width, grid.height
    info.origin.position.x, info.origin.position.y = grid.origin.x, grid.origin.y
    q = info.origin.orientation
    q.x, q.y, q.z, q.w = quaternion_from_yaw(grid.origin.yaw)
    message.data = np.ascontiguousarray(grid.cells, dtype=np.int8).reshape(-1)
    return message
