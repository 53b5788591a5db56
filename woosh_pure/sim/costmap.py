"""The costmap of the simulated navigation: costs by the distance to walls and seen obstacles. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray


TOPIC = "/move_base/global_costmap/costmap"
"""The name that move_base uses; it is not known whether the real chassis publishes it (assumed)."""
_CELL = 0.1  # m
_BEYOND = 0.5  # m beyond the robot's radius that have a cost
_OCCUPIED, _TOUCHES = 100, 99


class Costmap:
    """Costs for a round robot in a map.

    Args:
        grid: The walls.
        radius: The robot's radius, m.
    """

    def __init__(self, grid: GridMap, radius: float) -> None:
        self._factor = max(1, round(_CELL / grid.resolution))
        self._size = grid.resolution * self._factor
        self._grid, self._radius = grid, radius
        self._walls: NDArray[np.int8] | None = None

    def with_obstacles(self, obstacles: Iterable[tuple[float, float, float]]) -> GridMap:
        """Costs: 100 at an obstacle, 99 where the robot would touch it, less with distance.

        Args:
            things: Round obstacles: x, y, radius in m in the map.
        """
        if self._walls is None:
            self._walls = self._costs(self._coarse())
        cells = self._walls.copy()
        rows, columns = np.ogrid[: cells.shape[0], : cells.shape[1]]
        for x, y, radius in obstacles:
            row, column = (place / self._factor for place in self._grid.place_of(x, y))
            away = np.hypot(rows + 0.5 - row, columns + 0.5 - column) * self._size - radius
            np.maximum(cells, self._cost(np.maximum(away, 0.0)), out=cells)
        return GridMap(cells, self._size, self._grid.origin)

    def _coarse(self) -> NDArray[np.bool_]:
        f, walls = self._factor, self._grid.cells > 50
        rows, columns = -(-walls.shape[0] // f), -(-walls.shape[1] // f)
        padded = np.zeros((rows * f, columns * f), bool)
        padded[: walls.shape[0], : walls.shape[1]] = walls
        return np.asarray(padded.reshape(rows, f, columns, f).any(axis=(1, 3)))

    def _costs(self, walls: NDArray[np.bool_]) -> NDArray[np.int8]:
        reach = math.ceil((self._radius + _BEYOND) / self._size)
        rows, columns = walls.shape
        padded = np.pad(walls, reach)
        out = np.zeros(walls.shape, np.int8)
        for dr in range(-reach, reach + 1):
            for dc in range(-reach, reach + 1):
                cost = self._cost(np.array(math.hypot(dr, dc) * self._size))
                near = padded[reach + dr : reach + dr + rows, reach + dc : reach + dc + columns]
                np.maximum(out, np.where(near, cost, np.int8(0)), out=out)
        return out

    def _cost(self, away: NDArray[np.float64]) -> NDArray[np.int8]:
        """Costs for distances in m."""
        beyond = (away - self._radius) / _BEYOND
        falling = np.clip(np.rint(98.0 * (1.0 - beyond) ** 2), 1.0, 98.0)
        near = np.where(beyond < 1.0, np.where(beyond < 1e-6, _TOUCHES, falling), 0.0)
        return np.where(away <= 0.0, _OCCUPIED, near).astype(np.int8)
