"""A synthetic depth camera: walls of 2 m height and a floor, seen from 0.5 m. Pure numpy.

Not modelled: lens distortion, noise, texture, light.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.raycast import cast

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Camera"]


@dataclass(frozen=True, slots=True)
class Camera:
    """Looks forward, horizontally. Optical axes: x right, y down, z forward (REP 103)."""

    width: int = 160
    height: int = 120
    field_of_view: float = math.radians(70.0)
    above_floor: float = 0.5
    wall_height: float = 2.0
    most: float = 8.0

    @property
    def _focal(self) -> float:
        return self.width / 2.0 / math.tan(self.field_of_view / 2.0)

    def _metres(
        self, grid: GridMap, pose: Pose2D, obstacles: Sequence[tuple[float, float, float]]
    ) -> NDArray[np.float64]:
        """(height, width) depth along z in m, 0 where nothing is in reach."""
        columns = np.arange(self.width) - (self.width - 1) / 2.0
        angles = -np.arctan(columns / self._focal)
        ranges = cast(grid, pose, angles, self.most, obstacles).astype(np.float64)
        wall = ranges * np.cos(angles)
        rows = (np.arange(self.height) - (self.height - 1) / 2.0)[:, None] / self._focal
        depth = np.broadcast_to(wall, (self.height, self.width)).copy()
        with np.errstate(divide="ignore"):
            floor = np.where(rows > 0, self.above_floor / rows, np.inf)
            over = np.where(rows < 0, (self.wall_height - self.above_floor) / -rows, np.inf)
        depth = np.where(depth > over, np.inf, np.minimum(depth, floor))
        depth[~np.isfinite(depth) | (depth > self.most)] = 0.0
        return depth

    def depth(
        self, grid: GridMap, pose: Pose2D, obstacles: Sequence[tuple[float, float, float]] = ()
    ) -> NDArray[np.uint16]:
        """(height, width) uint16 mm, 0 where nothing was measured."""
        return (self._metres(grid, pose, obstacles) * 1000.0).astype(np.uint16)

    def color(
        self, grid: GridMap, pose: Pose2D, obstacles: Sequence[tuple[float, float, float]] = ()
    ) -> NDArray[np.uint8]:
        """(height, width, 3) uint8 RGB: the nearer, the brighter; the floor greenish."""
        depth = self._metres(grid, pose, obstacles)
        near = np.where(depth > 0.0, 255.0 * (1.0 - depth / self.most), 0.0)
        floor = self._is_floor(depth)
        channels = (np.where(floor, near * 0.6, near), near, np.where(floor, near * 0.6, near))
        return np.stack(channels, axis=-1).astype(np.uint8)

    def _is_floor(self, depth: NDArray[np.float64]) -> NDArray[np.bool_]:
        rows = (np.arange(self.height) - (self.height - 1) / 2.0)[:, None] / self._focal
        floor: NDArray[np.bool_] = depth * rows > self.above_floor - 0.02
        return floor

    def points(
        self,
        grid: GridMap,
        pose: Pose2D,
        obstacles: Sequence[tuple[float, float, float]] = (),
        *,
        floor: bool = True,
    ) -> NDArray[np.float32]:
        """(N, 3) float32 x, y, z in m in optical axes; without the floor when `floor` is False."""
        depth = self._metres(grid, pose, obstacles)
        columns = (np.arange(self.width) - (self.width - 1) / 2.0)[None, :] / self._focal
        rows = (np.arange(self.height) - (self.height - 1) / 2.0)[:, None] / self._focal
        points = np.stack([depth * columns, depth * rows, depth], axis=-1).reshape(-1, 3)
        keep = depth.reshape(-1) > 0.0
        if not floor:
            keep &= ~self._is_floor(depth).reshape(-1)
        return points[keep].astype(np.float32)
