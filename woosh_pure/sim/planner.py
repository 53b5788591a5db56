"""The map as the simulated navigation sees it. Pure.

`Planner` finds paths: A* on the inflated grid, then shortening. `Costmap` has costs by the distance
to walls and seen obstacles.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray


Obstacle = tuple[float, float, float]
"""A round obstacle: x, y, radius in m in the map."""
_Cell = tuple[int, int]
_NEIGHBOURS = [(-1, 0, 1.0), (1, 0, 1.0), (0, -1, 1.0), (0, 1, 1.0)] + [
    (a, b, math.sqrt(2.0)) for a in (-1, 1) for b in (-1, 1)
]


class Planner:
    """Plans for a round robot of `radius` m that keeps `clearance` m from obstacles, on cells of about 0.1 m.

    A robot that stands closer may leave, but only over cells where it touches nothing.
    """

    def __init__(self, grid: GridMap, radius: float, clearance: float = 0.0) -> None:
        self._factor = _factor_of(grid)
        self._grid = grid
        self._body = radius
        self._radius = radius + clearance
        occupied = _coarse(grid, self._factor, outside=True)
        self._static = self._inflate(occupied, self._radius)
        self._touching = self._inflate(occupied, radius)

    def plan(
        self,
        start: Pose2D,
        goal: Pose2D,
        obstacles: Iterable[Obstacle] = (),
        tolerance: float = 0.0,
    ) -> list[Pose2D] | None:
        """Way points from `start` to `goal` (both included); None if there is no path.

        A blocked goal is replaced by the nearest free cell within `tolerance` m.
        """
        blocked = self._with(obstacles)
        first, last = self._cell(start), self._cell(goal)
        end = self._nearest_free(blocked, last, tolerance)
        if end is None or not self._inside(first):
            return None
        cells = self._search(blocked, self._with(obstacles, touching=True), first, end)
        if cells is None:
            return None
        points = [self._point(cell) for cell in self._shorten(blocked, cells)]
        target = goal if end == last else Pose2D(*self._point(end), goal.yaw)
        middle = [Pose2D(x, y) for x, y in points[1:-1]]
        return [start, *middle, target]

    def nearest_free(self, x: float, y: float, within: float) -> tuple[float, float] | None:
        """The nearest free place for the robot's centre, in m; None if there is none within `within` m."""
        cell = self._nearest_free(self._static, self._cell(Pose2D(x, y)), within)
        return None if cell is None else self._point(cell)

    def is_free(self, x: float, y: float, obstacles: Iterable[Obstacle] = ()) -> bool:
        """Whether a place is free for the robot's centre."""
        cell = self._cell(Pose2D(x, y))
        blocked = self._with(obstacles)
        return self._inside(cell) and not bool(blocked[cell])

    @property
    def _size(self) -> float:
        return self._grid.resolution * self._factor

    def _inflate(self, occupied: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
        """Cells at whose centre the robot would touch an occupied cell."""
        out = np.zeros_like(occupied)
        reach = math.ceil(radius / self._size + 0.5)
        for dr, dc, near in _surroundings(occupied, reach, outside=True):
            if math.hypot(max(abs(dr) - 0.5, 0.0), max(abs(dc) - 0.5, 0.0)) * self._size < radius:
                np.logical_or(out, near, out=out)
        return out

    def _with(self, obstacles: Iterable[Obstacle], *, touching: bool = False) -> NDArray[np.bool_]:
        given = blocked = self._touching if touching else self._static
        own = self._body if touching else self._radius
        for x, y, radius in obstacles:
            blocked = blocked.copy() if blocked is given else blocked
            rows, columns = np.ogrid[: blocked.shape[0], : blocked.shape[1]]
            r, c = self._exact(x, y)
            reach = (radius + own) / self._size + 0.5  # it may pass at the edge of a cell
            np.logical_or(
                blocked, (rows + 0.5 - r) ** 2 + (columns + 0.5 - c) ** 2 <= reach * reach, out=blocked
            )
        return blocked

    def _exact(self, x: float, y: float) -> tuple[float, float]:
        row, column = self._grid.place_of(x, y)
        return row / self._factor, column / self._factor

    def _cell(self, pose: Pose2D) -> _Cell:
        r, c = self._exact(pose.x, pose.y)
        return math.floor(r), math.floor(c)

    def _point(self, cell: _Cell) -> tuple[float, float]:
        middle = (self._factor - 1) / 2.0  # of the fine cells in this one
        return self._grid.point_of(cell[0] * self._factor + middle, cell[1] * self._factor + middle)

    def _inside(self, cell: _Cell) -> bool:
        rows, columns = self._static.shape
        return bool(0 <= cell[0] < rows and 0 <= cell[1] < columns)

    def _nearest_free(self, blocked: NDArray[np.bool_], cell: _Cell, tolerance: float) -> _Cell | None:
        if self._inside(cell) and not blocked[cell]:
            return cell
        rows, columns = np.nonzero(~blocked)
        away = np.hypot(rows - cell[0], columns - cell[1])
        near = np.nonzero(away * self._size <= tolerance)[0]
        if not near.size:
            return None
        best = near[away[near].argmin()]
        return int(rows[best]), int(columns[best])

    def _search(
        self, blocked: NDArray[np.bool_], touching: NDArray[np.bool_], start: _Cell, goal: _Cell
    ) -> list[_Cell] | None:
        # The robot may stand in an inflated cell, and leave it.
        queue: list[tuple[float, float, _Cell]] = [(0.0, 0.0, start)]
        came: dict[_Cell, _Cell] = {}
        cost = {start: 0.0}
        while queue:
            _, so_far, cell = heapq.heappop(queue)
            if cell == goal:
                cells = [cell]
                while cell in came:
                    cell = came[cell]
                    cells.append(cell)
                return cells[::-1]
            if so_far > cost[cell]:
                continue
            for dr, dc, length in _NEIGHBOURS:
                near = (cell[0] + dr, cell[1] + dc)
                if not self._inside(near) or touching[near] or (blocked[near] and not blocked[cell]):
                    continue
                there = so_far + length * (5.0 if blocked[near] else 1.0)
                if there < cost.get(near, math.inf):
                    cost[near], came[near] = there, cell
                    rest = math.hypot(near[0] - goal[0], near[1] - goal[1])
                    heapq.heappush(queue, (there + rest, there, near))
        return None

    def _shorten(self, blocked: NDArray[np.bool_], cells: list[_Cell]) -> list[_Cell]:
        kept, at = [cells[0]], 0
        while at < len(cells) - 1:
            ahead = len(cells) - 1
            while ahead > at + 1 and not self._sees(blocked, cells[at], cells[ahead]):
                ahead -= 1
            kept.append(cells[ahead])
            at = ahead
        return kept

    def _sees(self, blocked: NDArray[np.bool_], a: _Cell, b: _Cell) -> bool:
        count = 2 * max(abs(b[0] - a[0]), abs(b[1] - a[1])) + 1
        rows = np.floor(np.linspace(a[0] + 0.5, b[0] + 0.5, count)).astype(np.intp)
        columns = np.floor(np.linspace(a[1] + 0.5, b[1] + 0.5, count)).astype(np.intp)
        return not bool(blocked[rows, columns].any())


def _factor_of(grid: GridMap) -> int:
    """The cells of a map in each direction that are one cell of about 0.1 m."""
    return max(1, round(0.1 / grid.resolution))


def _coarse(grid: GridMap, factor: int, *, outside: bool) -> NDArray[np.bool_]:
    """The occupied cells of a map, `factor` times as large. Outside of the map, a cell is occupied if
    `outside`."""
    occupied = grid.cells > 50
    rows, columns = -(-grid.height // factor), -(-grid.width // factor)
    rest = ((0, rows * factor - grid.height), (0, columns * factor - grid.width))
    padded = np.pad(occupied, rest, constant_values=outside)
    return np.asarray(padded.reshape(rows, factor, columns, factor).any(axis=(1, 3)), dtype=np.bool_)


def _surroundings(
    cells: NDArray[np.bool_], reach: int, *, outside: bool
) -> Iterator[tuple[int, int, NDArray[np.bool_]]]:
    """For each offset of rows and columns within `reach`: the cells that are at this offset of each cell."""
    rows, columns = cells.shape
    padded = np.pad(cells, reach, constant_values=outside)
    for dr in range(-reach, reach + 1):
        for dc in range(-reach, reach + 1):
            yield dr, dc, padded[reach + dr : reach + dr + rows, reach + dc : reach + dc + columns]


# -- the costmap ---------------------------------------------------------------------------------------------

COSTMAP_TOPIC = "/move_base/global_costmap/costmap"
"""The name that move_base uses; it is not known whether the real chassis publishes it (assumed)."""
_BEYOND = 0.5  # m beyond the robot's radius that have a cost
_OCCUPIED, _TOUCHES = 100, 99


class Costmap:
    """Costs for a round robot in a map.

    Args:
        grid: The walls.
        radius: The robot's radius, m.
    """

    def __init__(self, grid: GridMap, radius: float) -> None:
        self._factor = _factor_of(grid)
        self._size = grid.resolution * self._factor
        self._grid, self._radius = grid, radius
        self._walls: NDArray[np.int8] | None = None

    def with_obstacles(self, obstacles: Iterable[Obstacle]) -> GridMap:
        """Costs: 100 at an obstacle, 99 where the robot would touch it, less with distance."""
        if self._walls is None:
            self._walls = self._costs()
        cells = self._walls.copy()
        rows, columns = np.ogrid[: cells.shape[0], : cells.shape[1]]
        for x, y, radius in obstacles:
            row, column = (place / self._factor for place in self._grid.place_of(x, y))
            away = np.hypot(rows + 0.5 - row, columns + 0.5 - column) * self._size - radius
            np.maximum(cells, self._cost(np.maximum(away, 0.0)), out=cells)
        return GridMap(cells, self._size, self._grid.origin)

    def _costs(self) -> NDArray[np.int8]:
        walls = _coarse(self._grid, self._factor, outside=False)
        out = np.zeros(walls.shape, np.int8)
        reach = math.ceil((self._radius + _BEYOND) / self._size)
        for dr, dc, near in _surroundings(walls, reach, outside=False):
            cost = self._cost(np.array(math.hypot(dr, dc) * self._size))
            np.maximum(out, np.where(near, cost, np.int8(0)), out=out)
        return out

    def _cost(self, away: NDArray[np.float64]) -> NDArray[np.int8]:
        """Costs for distances in m."""
        beyond = (away - self._radius) / _BEYOND
        falling = np.clip(np.rint(98.0 * (1.0 - beyond) ** 2), 1.0, 98.0)
        near = np.where(beyond < 1.0, np.where(beyond < 1e-6, _TOUCHES, falling), 0.0)
        return np.where(away <= 0.0, _OCCUPIED, near).astype(np.int8)
