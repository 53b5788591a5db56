"""Encodes the binary frames of the live connection (scan, camera, costmap). Numbers are little-endian; the
first byte is the kind. A frame is encoded once for all viewers.

    scan     B kind=1, B 0, H count, 5f x y yaw angle_min angle_increment (laser in the map, m and rad),
             then count H: centimetres, 0 for no measurement
    camera   B kind=2, B source (0 colour, 1 depth), then a JPEG
    costmap  B kind=3, B 0, H width, H height, H row, 4f resolution x y yaw, then some rows of width B from
             that row on: cost 0 to 100, 255 for not known; the row at the origin comes first. The parts of
             a costmap come in order, with other frames in between
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING

import numpy as np

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D

if TYPE_CHECKING:
    from numpy.typing import NDArray


SCAN, CAMERA, COSTMAP = 1, 2, 3
SOURCES = ("color", "depth")
MAX_RANGES = 2000
"""A scan with more ranges is thinned to every second, third ... range; a screen cannot show more."""
MAX_CELLS, PART = 250_000, 8 * 1024
"""Most cells of a costmap, and most bytes of one part. A screen does not show more cells, and over a slow
link a part delays other frames no longer than a camera picture."""
_HEAD = struct.Struct("<BBH5f")
_GRID = struct.Struct("<BBHHH4f")


def scan_frame(
    ranges: NDArray[np.float32], limits: tuple[float, float], angles: tuple[float, float], laser: Pose2D
) -> bytes:
    """A scan.

    Args:
        ranges: (N,) m.
        limits: The shortest and the longest valid range, m.
        angles: The first range's angle, and the step from one to the next, rad, in the laser's frame.
        laser: Pose of the laser in the map.
    """
    step = max(1, math.ceil(ranges.size / MAX_RANGES))
    ranges = ranges[::step]
    with np.errstate(invalid="ignore"):
        seen = (ranges >= limits[0]) & (ranges <= min(limits[1], 655.0))
        centimetres = np.where(seen, np.rint(ranges * np.float32(100.0)), 0.0).astype("<u2")
    head = _HEAD.pack(SCAN, 0, centimetres.size, laser.x, laser.y, laser.yaw, angles[0], angles[1] * step)
    return head + centimetres.tobytes()


def camera_frame(source: str, jpeg: bytes) -> bytes:
    """A camera picture; the source is "color" or "depth"."""
    return bytes((CAMERA, SOURCES.index(source))) + jpeg


def costmap_frames(cells: NDArray[np.int8], resolution: float, origin: Pose2D) -> tuple[bytes, ...]:
    """A costmap in parts, between which other frames are sent. One of more than `MAX_CELLS` is scaled down:
    each cell then has the highest cost of those it stands for.

    Args:
        cells: (height, width) int8, 0 to 100, -1 for not known.
        resolution: Size of a cell, m.
        origin: Pose of its first cell's corner in the map.

    Raises:
        ValueError: It has no cells, more than 65535 in one direction, or a place that is not finite.
    """
    step = math.ceil(math.sqrt(cells.size / MAX_CELLS))
    if step > 1:
        rows, columns = (np.arange(0, size, step) for size in cells.shape)
        cells = np.maximum.reduceat(np.maximum.reduceat(cells, rows, axis=0), columns, axis=1)
        resolution *= step
    height, width = cells.shape
    if not 0 < min(height, width) <= max(height, width) <= 0xFFFF:
        raise ValueError(
            say("a costmap of {width} x {height} cells cannot be shown", width=width, height=height)
        )
    if not all(map(math.isfinite, (resolution, origin.x, origin.y, origin.yaw))):
        raise ValueError("a costmap whose place is not a number cannot be shown")
    many = max(1, PART // width)
    return tuple(
        _GRID.pack(COSTMAP, 0, width, height, row, resolution, origin.x, origin.y, origin.yaw)
        + cells[row : row + many].astype(np.uint8).tobytes()
        for row in range(0, height, many)
    )
