"""Where the simulated robot lives: a map, its marks, and the built-in small hall. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import OCCUPIED, GridMap

__all__ = ["Mark", "Site", "built_in_site"]


@dataclass(frozen=True, slots=True)
class Mark:
    """A named place, a storage mark.

    Attributes:
        pose: In the map.
        charger: True for a charging dock.
        waits: True when a task waits here until it is interrupted (task state 5).
    """

    pose: Pose2D
    charger: bool = False
    waits: bool = False


@dataclass(frozen=True)
class Site:
    """A map with its marks and the place where the robot is switched on."""

    grid: GridMap
    marks: dict[str, Mark] = field(default_factory=dict)
    start: Pose2D = Pose2D(0.0, 0.0)  # noqa: RUF009  (frozen)


_HALL = """
########################
#......................#
#......................#
#......##........##....#
#......##........##....#
#......................#
#......................#
#..........####........#
#......................#
#......................#
#......##........##....#
#......##........##....#
#......................#
#......................#
#......................#
########################
"""


def built_in_site(resolution: float = 0.05) -> Site:
    """A hall of 12 m x 8 m with five pillars and six marks; the origin (0, 0) is a free place in its
    middle left."""
    lines = _HALL.strip().splitlines()
    coarse = np.array([[c == "#" for c in line] for line in reversed(lines)])
    factor = round(0.5 / resolution)
    cells = np.kron(coarse, np.ones((factor, factor))).astype(np.int8) * OCCUPIED
    grid = GridMap(cells, resolution, Pose2D(-2.0, -4.0, 0.0))
    marks = {
        "A1": Mark(Pose2D(3.0, 1.0, math.pi / 2)),
        "A2": Mark(Pose2D(5.5, 2.5, math.pi)),
        "B1": Mark(Pose2D(8.5, -2.0, 0.0)),
        "B2": Mark(Pose2D(4.5, -2.5, -math.pi / 2)),
        "W1": Mark(Pose2D(1.0, -1.5, 0.0), waits=True),
        "P1": Mark(Pose2D(-0.5, 2.5, 0.0)),
        "C1": Mark(Pose2D(-0.9, -3.0, math.pi), charger=True),
    }
    return Site(grid, marks, Pose2D(0.0, 0.0, 0.0))
