"""`GridMap`: an occupancy grid as a value (numpy cells, resolution, origin), and its conversion from and to
messages.

Rows run south to north as in nav_msgs/OccupancyGrid (row 0 at the origin); image files run north to south.
Source: wiki.ros.org/map_server.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.codec import DynamicMessage
from rosproto.files import write_file
from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.hints import MAP, Hints
from woosh_pure.values.messages import message_type, pose_of, set_pose

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


FREE = 0
OCCUPIED = 100
UNKNOWN = -1


@dataclass(frozen=True, eq=False)
class GridMap(Hints):
    """An occupancy grid.

    Attributes:
        cells: (height, width) int8: 0 free, 100 occupied, -1 unknown; row 0 at the origin.
        resolution: Metres per cell.
        origin: Pose of the lower left corner of cell (0, 0), in the map frame.
    """

    _hints = MAP

    cells: NDArray[np.int8]
    resolution: float
    origin: Pose2D = Pose2D(0.0, 0.0)  # noqa: RUF009  (frozen)

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or 0 in self.cells.shape:
            raise ValueError(
                say("a map needs (height, width) cells, got shape {shape}", shape=self.cells.shape)
            )
        if not (math.isfinite(self.resolution) and self.resolution > 0):
            wrong = "resolution {resolution}: must be a positive number of metres per cell"
            raise ValueError(say(wrong, resolution=self.resolution))
        self.origin.require_finite()

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.cells.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.cells.shape[1])

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """(row, column) of a point in m in the map frame; may be outside the map."""
        row, column = self.place_of(x, y)
        return math.floor(row), math.floor(column)

    def place_of(self, x: float, y: float) -> tuple[float, float]:
        """(row, column) of a point in m in the map frame, with fractions; cells begin at whole numbers."""
        dx, dy = x - self.origin.x, y - self.origin.y
        if self.origin.yaw:
            c, s = math.cos(-self.origin.yaw), math.sin(-self.origin.yaw)
            dx, dy = c * dx - s * dy, s * dx + c * dy
        return dy / self.resolution, dx / self.resolution

    def point_of(self, row: float, column: float) -> tuple[float, float]:
        """Centre of a cell, m in the map frame."""
        dx, dy = (column + 0.5) * self.resolution, (row + 0.5) * self.resolution
        c, s = math.cos(self.origin.yaw), math.sin(self.origin.yaw)
        return self.origin.x + c * dx - s * dy, self.origin.y + s * dx + c * dy

    def contains(self, x: float, y: float) -> bool:
        """Whether a point is on the map."""
        row, column = self.cell_of(x, y)
        return 0 <= row < self.height and 0 <= column < self.width

    def is_occupied(self, x: float, y: float) -> bool:
        """Whether a point is occupied or outside the map; unknown cells count as free."""
        row, column = self.cell_of(x, y)
        if not (0 <= row < self.height and 0 <= column < self.width):
            return True
        return bool(self.cells[row, column] > 50)

    @classmethod
    def load(cls, yaml_path: str | Path, *, limit_cells: int = 100_000_000, beside: bool = False) -> GridMap:
        """Read map_server's YAML and its image: PGM, PPM or PNG, in any of the three modes.

        The image's path is relative to the YAML. Mode raw keeps the image's numbers. With `beside`, for files
        from untrusted sources, the image must be beside the YAML: its folder is ignored. A warning is logged
        when free_thresh makes cells free that map_saver wrote as unknown.

        Raises:
            ValueError: A file is invalid, or a number is out of range; the message says which one and why.
            OSError: A file cannot be read.
        """
        from woosh_pure.maps.mapfiles import read_map

        cells, resolution, origin = read_map(Path(yaml_path), limit_cells, beside=beside)
        try:
            return GridMap(cells, resolution, origin)
        except ValueError as error:
            raise ValueError(say("{yaml_path}: {error}", yaml_path=yaml_path, error=error)) from error

    def save(self, yaml_path: str | Path) -> tuple[Path, Path]:
        """Write `name.yaml` and `name.pgm` as map_saver does, and return both; given `name.png`, that, too.

        The endings .yaml, .yml, .pgm and .png are not part of the name.

        Raises:
            ValueError: The name is empty, or has characters that are not printable.
            OSError: A file cannot be written.
        """
        from woosh_pure.maps.mapfiles import write_map

        files = write_map(Path(yaml_path), self.to_grey(), self.resolution, self.origin)
        if Path(yaml_path).suffix.lower() == ".png":
            self.save_png(yaml_path)
        return files

    def save_png(self, path: str | Path) -> Path:
        """Write a grey PNG picture: white free, black occupied, grey unknown."""
        from rosproto.numeric import encode_png

        out = Path(path)
        write_file(out, encode_png(self.to_grey()))
        return out

    def to_grey(self) -> NDArray[np.uint8]:
        """(height, width) uint8 picture, north up, with map_saver's greys 254, 0, 205."""
        import numpy as np

        grey = np.full(self.cells.shape, 205, np.uint8)
        grey[(self.cells >= 0) & (self.cells <= 25)] = 254
        grey[self.cells >= 65] = 0
        return grey[::-1]


# -- nav_msgs/OccupancyGrid to a `GridMap` and back ----------------------------------------------------------


def grid_from_message(message: DynamicMessage) -> GridMap:
    """The map of a message; the cells are a view of the message's memory where it allows that.

    Raises:
        ValueError: Fewer cells than the message says.
    """
    import numpy as np

    info = message.info
    cells = np.asarray(message.data, dtype=np.int8)
    if cells.size != info.width * info.height:
        wrong = "map of {width} x {height} cells has {size}; the sender's data is wrong"
        raise ValueError(say(wrong, width=info.width, height=info.height, size=cells.size))
    origin = pose_of(info.origin, message.header.frame_id or "map")
    resolution = float(str(np.float32(info.resolution)))  # 0.05, which a float32 holds as 0.05000000074505806
    return GridMap(cells.reshape(info.height, info.width), resolution, origin)


def grid_message(grid: GridMap) -> DynamicMessage:
    """nav_msgs/OccupancyGrid of a map."""
    import numpy as np

    message = message_type("nav_msgs/OccupancyGrid")()
    message.header.frame_id = "map"
    info = message.info
    info.resolution, info.width, info.height = grid.resolution, grid.width, grid.height
    set_pose(info.origin, grid.origin)
    message.data = np.ascontiguousarray(grid.cells, dtype=np.int8).reshape(-1)
    return message
