"""The simulated lidar and depth camera: rays through the grid and round obstacles, walls of 2 m, a floor, and
a camera at 0.5 m. Pure numpy.

Not modelled: lens distortion, noise, texture, light.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.planner import Obstacle

if TYPE_CHECKING:
    from numpy.typing import NDArray


def cast(
    grid: GridMap,
    pose: Pose2D,
    angles: NDArray[np.float64],
    max_range: float,
    obstacles: Sequence[Obstacle] = (),
) -> NDArray[np.float32]:
    """Distances along rays.

    Args:
        grid: The map; the outside counts as occupied.
        pose: Pose of the lidar in the map.
        angles: (N,) rad relative to the pose.
        max_range: Longest range in m; inf for rays that hit nothing.
        obstacles: Circles.

    Returns:
        (N,) float32 ranges in m, a new array.
    """
    # All rays advance together in steps of half a cell, which is the error of the result.
    step = grid.resolution / 2.0
    count = int(max_range / step) + 1
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
    distance[distance > max_range] = math.inf
    return distance.astype(np.float32)


def _to_circle(
    c: NDArray[np.float64], s: NDArray[np.float64], dx: float, dy: float, radius: float
) -> NDArray[np.float64]:
    along = c * dx + s * dy
    square = radius * radius - (dx * dx + dy * dy - along * along)
    near = along - np.sqrt(np.maximum(square, 0.0))
    return np.where((square >= 0.0) & (near >= 0.0), near, np.inf)


# -- the depth camera ----------------------------------------------------------------------------------------
#
# It looks forward, horizontally. Optical axes: x right, y down, z forward (REP 103).

_WIDTH, _HEIGHT = 160, 120
_ABOVE_FLOOR, _WALL_HEIGHT, _MAX_DEPTH = 0.5, 2.0, 8.0  # m
_FOCAL = _WIDTH / 2.0 / math.tan(math.radians(70.0) / 2.0)
_COLUMNS = (np.arange(_WIDTH) - (_WIDTH - 1) / 2.0)[None, :] / _FOCAL
_ROWS = (np.arange(_HEIGHT) - (_HEIGHT - 1) / 2.0)[:, None] / _FOCAL


def _metres(grid: GridMap, pose: Pose2D, obstacles: Sequence[Obstacle]) -> NDArray[np.float64]:
    """(height, width) depth along z in m; 0 where nothing is in range."""
    angles = -np.arctan(_COLUMNS[0])
    wall = cast(grid, pose, angles, _MAX_DEPTH, obstacles).astype(np.float64) * np.cos(angles)
    floor = np.where(_ROWS > 0, _ABOVE_FLOOR / _ROWS, np.inf)
    over = np.where(_ROWS < 0, (_WALL_HEIGHT - _ABOVE_FLOOR) / -_ROWS, np.inf)
    depth = np.where(wall > over, np.inf, np.minimum(wall, floor))
    depth[~np.isfinite(depth) | (depth > _MAX_DEPTH)] = 0.0
    return depth


def _is_floor(depth: NDArray[np.float64]) -> NDArray[np.bool_]:
    floor: NDArray[np.bool_] = depth * _ROWS > _ABOVE_FLOOR - 0.02
    return floor


def camera_depth(grid: GridMap, pose: Pose2D, obstacles: Sequence[Obstacle] = ()) -> NDArray[np.uint16]:
    """(height, width) uint16 mm; 0 where nothing was measured."""
    return (_metres(grid, pose, obstacles) * 1000.0).astype(np.uint16)


def camera_picture(grid: GridMap, pose: Pose2D, obstacles: Sequence[Obstacle] = ()) -> NDArray[np.uint8]:
    """(height, width, 3) uint8 RGB: near is bright; the floor is greenish."""
    depth = _metres(grid, pose, obstacles)
    near = np.where(depth > 0.0, 255.0 * (1.0 - depth / _MAX_DEPTH), 0.0)
    other = np.where(_is_floor(depth), near * 0.6, near)
    return np.stack((other, near, other), axis=-1).astype(np.uint8)


def camera_points(
    grid: GridMap, pose: Pose2D, obstacles: Sequence[Obstacle] = (), *, floor: bool = True
) -> NDArray[np.float32]:
    """(N, 3) float32 x, y, z in m in optical axes; without the floor when `floor` is False."""
    depth = _metres(grid, pose, obstacles)
    keep = depth > 0.0
    if not floor:
        keep &= ~_is_floor(depth)
    points = np.stack([depth * _COLUMNS, depth * _ROWS, depth], axis=-1)
    return points[keep].astype(np.float32)
