"""What the lidar sees: many rays through the grid at once, and round obstacles. Pure numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["cast"]


def cast(
    grid: GridMap,
    pose: Pose2D,
    angles: NDArray[np.float64],
    most: float,
    obstacles: Sequence[tuple[float, float, float]] = (),
) -> NDArray[np.float32]:
    """Distances along rays.

    Args:
        grid: The map; the outside counts as occupied.
        pose: Of the lidar, in the map.
        angles: (N,) rad relative to the pose.
        most: Longest range in m; rays that hit nothing give inf.
        obstacles: Circles (x, y, radius) in m.

    Returns:
        (N,) float32 ranges in m, a new array.
    """
    # Marching in half-cell steps, all rays abreast: the hit is right within half a cell.
    step = grid.resolution / 2.0
    count = int(most / step) + 1
    directions = angles + pose.yaw
    c, s = np.cos(directions), np.sin(directions)
    distance = np.full(angles.shape, np.inf)
    blocked = np.pad(grid.cells > 50, 1, constant_values=True)
    y0, x0 = grid.place_of(pose.x, pose.y)
    turned = directions - grid.origin.yaw  # along the axes of the grid
    along, across = np.cos(turned), np.sin(turned)
    block = 64
    active = np.arange(angles.size)
    for first in range(0, count, block):
        reach = np.arange(first, min(first + block, count)) * (step / grid.resolution)
        columns = np.clip(
            np.floor(x0 + np.outer(along[active], reach)).astype(np.intp) + 1, 0, grid.width + 1
        )
        rows = np.clip(np.floor(y0 + np.outer(across[active], reach)).astype(np.intp) + 1, 0, grid.height + 1)
        hit = blocked[rows, columns]
        found = hit.any(axis=1)
        distance[active[found]] = (first + hit[found].argmax(axis=1)) * step
        active = active[~found]
        if not active.size:
            break
    for ox, oy, radius in obstacles:
        distance = np.minimum(distance, _to_circle(c, s, ox - pose.x, oy - pose.y, radius))
    distance[distance > most] = math.inf
    return distance.astype(np.float32)


def _to_circle(
    c: NDArray[np.float64], s: NDArray[np.float64], dx: float, dy: float, radius: float
) -> NDArray[np.float64]:
    along = c * dx + s * dy
    square = radius * radius - (dx * dx + dy * dy - along * along)
    near = along - np.sqrt(np.maximum(square, 0.0))
    return np.where((square >= 0.0) & (near >= 0.0), near, np.inf)
