"""A map as RGB pixels, on which shapes are drawn that are given in metres."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.cli.letters import put_text
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Picture"]

ROBOT, GOAL = (220, 30, 30), (20, 150, 60)
_LONGEST, _SHORTEST = 4000, 400


class Picture:
    """RGB pixels over a map; shapes are given in metres in the map's frame, and cut at its edges.

    Attributes:
        pixels: (height, width, 3) uint8, north up.
        scale: Pixels for each cell of the map.
    """

    def __init__(self, grid: GridMap) -> None:
        longest = max(grid.width, grid.height)
        self.grid = grid
        self.scale = 1 if longest >= _SHORTEST else min(8, math.ceil(_SHORTEST / longest))
        self._step = max(1, math.ceil(longest / _LONGEST))  # a huge map is thinned out
        grey = grid.to_grey()[:: self._step, :: self._step]
        grey = np.repeat(np.repeat(grey, self.scale, axis=0), self.scale, axis=1)
        self.pixels: NDArray[np.uint8] = np.repeat(grey[:, :, None], 3, axis=2)

    @property
    def pixels_per_metre(self) -> float:
        """How large a metre is in it."""
        return self.scale / (self.grid.resolution * self._step)

    def dots(self, points: NDArray[np.floating], color: Sequence[int], radius: int = 1) -> None:
        """(N, 2) points in m as small squares."""
        if len(points) == 0:
            return
        rows, columns = self._pixels_of(np.asarray(points, dtype=np.float64))
        height, width = self.pixels.shape[:2]
        for down in range(-radius, radius + 1):
            for right in range(-radius, radius + 1):
                r, c = rows + down, columns + right
                inside = (r >= 0) & (r < height) & (c >= 0) & (c < width)
                self.pixels[r[inside], c[inside]] = color

    def line(self, points: Iterable[tuple[float, float]], color: Sequence[int], radius: int = 1) -> None:
        """A line through points in m."""
        corners = list(points)
        step = self.grid.resolution * self._step / self.scale / 2.0
        for (x0, y0), (x1, y1) in itertools.pairwise(corners):
            count = min(100_000, max(2, math.ceil(math.hypot(x1 - x0, y1 - y0) / step)))
            along = np.linspace(0.0, 1.0, count)[:, None]
            self.dots(np.array([[x0, y0]]) * (1.0 - along) + np.array([[x1, y1]]) * along, color, radius)

    def robot(self, pose: Pose2D, size: float = 0.35) -> None:
        """A circle of `size` m with a line in the direction it looks."""
        angles = np.linspace(0.0, 2.0 * math.pi, 73)
        ring = [(pose.x + size * math.cos(a), pose.y + size * math.sin(a)) for a in angles]
        tip = (pose.x + 1.6 * size * math.cos(pose.yaw), pose.y + 1.6 * size * math.sin(pose.yaw))
        self.line(ring, ROBOT)
        self.line([(pose.x, pose.y), tip], ROBOT)

    def mark(self, name: str, pose: Pose2D, size: float = 0.2) -> None:
        """A small triangle that looks where a robot at the mark does, and its name beside it."""
        size = max(size, 6.0 / self.pixels_per_metre)
        corners = [(2.0 * size, 0.0), (-size, size), (-size, -size), (2.0 * size, 0.0)]
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        self.line([(pose.x + c * x - s * y, pose.y + s * x + c * y) for x, y in corners], GOAL)
        rows, columns = self._pixels_of(np.array([[pose.x, pose.y]]))
        away = round(2.0 * size * self.pixels_per_metre) + 5
        put_text(self.pixels, name, int(columns[0]) + away, int(rows[0]) - 5, GOAL, on_paper=True)

    def _pixels_of(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        origin, size = self.grid.origin, self.grid.resolution * self._step
        dx, dy = points[:, 0] - origin.x, points[:, 1] - origin.y
        c, s = math.cos(-origin.yaw), math.sin(-origin.yaw)
        columns = np.floor((c * dx - s * dy) / size * self.scale).astype(np.int64)
        rows = self.pixels.shape[0] - 1 - np.floor((s * dx + c * dy) / size * self.scale).astype(np.int64)
        return rows, columns
