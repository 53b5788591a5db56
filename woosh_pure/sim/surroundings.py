"""What surrounds the simulated robot: walls, and obstacles that are on no map. Pure."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.gridmap import GridMap

__all__ = ["Obstacle", "Surroundings"]

Obstacle = tuple[float, float, float]
"""A round obstacle: x, y, radius in m in the map."""

_SIGHT = 4.0  # m


class Surroundings:
    """Walls and things, and whether a round robot touches them.

    Attributes:
        things: Obstacles that are not on the map.
        seen: Those of them that the costmaps know.
    """

    def __init__(self, walls: GridMap, radius: float) -> None:
        self._walls = walls
        self._radius = radius  # of the robot, m
        self.things: list[Obstacle] = []
        self.seen: list[Obstacle] = []

    def look(self, pose: Pose2D) -> None:
        """Note the obstacles in sight, and forget those that have gone."""

        def in_sight(thing: Obstacle) -> bool:
            return math.hypot(thing[0] - pose.x, thing[1] - pose.y) < _SIGHT + thing[2]

        self.seen = [thing for thing in self.seen if thing in self.things or not in_sight(thing)]
        self.seen += [thing for thing in self.things if in_sight(thing) and thing not in self.seen]

    def touches(self, x: float, y: float, *, more: float = 0.0, known: bool = False) -> bool:
        """Whether the robot, standing there, would touch something; outside of the map is a wall.

        Args:
            x, y: m in the map.
            more: By how much it is taken to be larger, m.
            known: Look at walls and what the costmaps know, not at all that is there.
        """
        radius = self._radius + more
        things = self.seen if known else self.things
        if any(math.hypot(ox - x, oy - y) < r + radius for ox, oy, r in things):
            return True
        grid = self._walls
        row, column = grid.cell_of(x, y)
        reach = math.ceil(radius / grid.resolution)
        r0, r1, c0, c1 = row - reach, row + reach + 1, column - reach, column + reach + 1
        if r0 < 0 or c0 < 0 or r1 > grid.height or c1 > grid.width:
            return True
        window = grid.cells[r0:r1, c0:c1] > 50
        return bool(window.any()) and bool((window & _disc(reach, radius / grid.resolution)).any())

    def obstructed(self, pose: Pose2D, direction: Velocity, ahead: float) -> bool:
        """Whether an obstacle is within `ahead` m in a direction of the robot's own axes."""
        for k in range(1, math.ceil(ahead / 0.1) + 1):
            reach = min(ahead, 0.1 * k)
            there = pose.transformed(direction.vx * reach, direction.vy * reach, 0.0)
            if self.touches(there.x, there.y):
                return True
        return False

    def is_clear(self, a: Pose2D, b: Pose2D, *, more: float = 0.0, step: float = 0.025) -> bool:
        """Whether the robot, larger by `more` m, touches nothing that it knows on the straight way from one
        place to another, looked at every `step` m.
        """
        dx, dy = b.x - a.x, b.y - a.y
        parts = max(1, math.ceil(math.hypot(dx, dy) / step))
        return not any(
            self.touches(a.x + dx * k / parts, a.y + dy * k / parts, more=more, known=True)
            for k in range(parts + 1)
        )


@lru_cache(maxsize=64)
def _disc(reach: int, radius: float) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    offsets = np.arange(-reach, reach + 1)
    result: np.ndarray[tuple[int, ...], np.dtype[np.bool_]] = (
        offsets[:, None] ** 2 + offsets[None, :] ** 2 <= radius**2
    )
    return result
