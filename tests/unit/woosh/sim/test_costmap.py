"""What the simulated navigation says it keeps clear of."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from woosh_pure import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.sim.planner import Costmap

RADIUS = 0.3


def cost(grid: GridMap, x: float, y: float) -> int:
    return int(grid.cells[grid.cell_of(x, y)])


def hall() -> GridMap:
    """4 m by 4 m, one wall of a cell in the middle."""
    cells = np.zeros((80, 80), np.int8)
    cells[:, 40] = 100
    return GridMap(cells, 0.05, Pose2D(-2.0, -2.0))


def test_cost_falls_with_the_way_to_a_wall() -> None:
    found = Costmap(hall(), RADIUS).with_obstacles([])
    assert (found.width, found.height, found.origin) == (40, 40, Pose2D(-2.0, -2.0))
    along = [cost(found, 0.05 + 0.1 * k, 0.0) for k in range(12)]
    assert along[0] == 100
    assert along[1:4] == [99, 99, 99], "the robot would touch it"
    assert all(a > b for a, b in pairwise(along[3:9]))
    assert along[9:] == [0, 0, 0]
    assert cost(found, -0.95, 0.0) == 0


def test_things_are_added_and_forgotten() -> None:
    costmap = Costmap(hall(), RADIUS)
    thing = costmap.with_obstacles([(1.25, 1.25, 0.2)])
    assert cost(thing, 1.25, 1.25) == 100
    assert cost(thing, 1.25, 0.85) == 99
    assert 0 < cost(thing, 1.25, 0.65) < 99
    assert cost(costmap.with_obstacles([]), 1.25, 1.25) == 0


def test_what_is_not_known_is_no_wall_and_a_rest_of_a_cell_counts() -> None:
    cells = np.full((31, 31), -1, np.int8)
    cells[30, 30] = 100
    found = Costmap(GridMap(cells, 0.05), RADIUS).with_obstacles([])
    assert found.cells.shape == (16, 16)
    assert found.cells[15, 15] == 100
    assert found.cells[0, 0] == 0
