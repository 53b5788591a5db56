"""A map with robot, path, scan and marks as an RGB picture."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.cli.canvas import Picture
from woosh_pure.cli.chart import draw_grid, framed
from woosh_pure.cli.letters import can_draw
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from woosh_pure.maps.marks import UserMark

__all__ = ["blank_around", "chart_of", "picture_of"]

PATH, SCAN = (30, 90, 220), (240, 130, 0)


def picture_of(
    grid: GridMap,
    *,
    pose: Pose2D | None = None,
    scan: NDArray[np.floating] | None = None,
    path: Sequence[Pose2D] = (),
) -> NDArray[np.uint8]:
    """A map with what is known drawn in: path blue, scan orange, robot red."""
    picture = Picture(grid)
    _draw(picture, pose, scan, path)
    return picture.pixels


def chart_of(
    grid: GridMap,
    *,
    pose: Pose2D | None = None,
    scan: NDArray[np.floating] | None = None,
    path: Sequence[Pose2D] = (),
    marks: Iterable[UserMark] = (),
) -> tuple[NDArray[np.uint8], list[str]]:
    """As `picture_of`, with a grid, its numbers, a scale bar and the marks (green).

    Returns:
        The picture, and a line for each mark whose name the letters lack: it has a number in the picture.
    """
    picture = Picture(grid)
    notes: list[str] = []
    draw_grid(picture)
    for mark in marks:
        if mark.pose is None or not grid.contains(mark.pose.x, mark.pose.y):
            continue
        name = mark.name
        if not can_draw(name):
            name = f"#{len(notes) + 1}"
            notes.append(f"{name} in the picture: {mark.name}")
        picture.mark(name, mark.pose)
    _draw(picture, pose, scan, path)
    return framed(picture), notes


def _draw(
    picture: Picture, pose: Pose2D | None, scan: NDArray[np.floating] | None, path: Sequence[Pose2D]
) -> None:
    picture.line([(p.x, p.y) for p in path], PATH)
    if scan is not None:
        picture.dots(scan, SCAN)
    if pose is not None:
        picture.robot(pose)


def blank_around(points: NDArray[np.floating], *, resolution: float = 0.05, margin: float = 1.0) -> GridMap:
    """An empty map that holds the points (N, 2) m and the origin, for pictures without a map."""
    corners = np.vstack([np.asarray(points, dtype=np.float64).reshape(-1, 2), [[0.0, 0.0]]])
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    width, height = (math.ceil(float(v) / resolution) for v in high - low)
    cells = np.zeros((height, width), np.int8)
    return GridMap(cells, resolution, Pose2D(float(low[0]), float(low[1])))
