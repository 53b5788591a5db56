"""nav_msgs/OccupancyGrid as an array, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rosproto.codec import DynamicMessage, Message, message_class

if TYPE_CHECKING:
    from msgdefs.nav_msgs.msg import OccupancyGrid


def grid_to_array(grid: OccupancyGrid | DynamicMessage) -> NDArray[np.int8]:
    """The cells of a nav_msgs/OccupancyGrid.

    Returns:
        (H, W) int8, `[row, column]`: -1 unknown, 0 free to 100 occupied. Row 0 is at the origin's y, so it is
        the *lowest* row of the map (flip with `[::-1]` for a picture); cell [r, c] is centred at ((c + 0.5),
        (r + 0.5)) * info.resolution in the frame of info.origin. A view of `grid.data` (a copy of a list or
        tuple).

    Raises:
        ValueError: info and data are inconsistent.
    """
    cells = np.asarray(grid.data, np.int8).reshape(-1)
    height, width = grid.info.height, grid.info.width
    if cells.size != height * width:
        raise ValueError(f"a grid of {width}x{height} has {height * width} cells, but data has {cells.size}")
    return cells.reshape(height, width)


def array_to_grid(
    cells: ArrayLike, resolution: float, *, origin: Message | None = None, header: Message | None = None
) -> Any:
    """A nav_msgs/OccupancyGrid of an array.

    Args:
        cells: (H, W) int8 as returned by `grid_to_array`.
        resolution: Metres per cell.
        origin: geometry_msgs/Pose of cell [0, 0]'s outer corner in the frame of `header`; zero by default.
        header: A std_msgs/Header to use; a new one by default.

    Raises:
        ValueError: Shape or values are invalid.
    """
    array = np.asarray(cells)
    if array.ndim != 2 or (array.size and (array.min() < -1 or array.max() > 100)):
        raise ValueError(f"cells must be (H, W) of -1..100, not {array.shape} of {array.dtype}")
    grid = message_class("nav_msgs/OccupancyGrid")(header=header, data=array.astype(np.int8).reshape(-1))
    grid.info.height, grid.info.width = array.shape
    grid.info.resolution = resolution
    if origin is None:
        grid.info.origin.orientation.w = 1.0
    else:
        grid.info.origin = origin
    return grid
