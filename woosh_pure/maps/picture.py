"""A map as a picture: a grid in metres with its numbers, a scale bar, marks, path, scan and robot.

Pillow (extra `cli`) draws it. Without Pillow the plain map is written.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import MarkFile, UserMark, mark_file

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from PIL.Image import Image

    from woosh_pure.cli.output import Output


Color = tuple[int, int, int]
ROBOT, MARK, PATH, SCAN = (220, 30, 30), (20, 150, 60), (30, 90, 220), (240, 130, 0)
INK, PAPER, LINES = (40, 50, 60), (255, 255, 255), (206, 218, 232)
LEFT, RIGHT, TOP, BOTTOM = 44, 12, 12, 44
"""Pixels of the margins."""
_MAX_PIXELS, _MIN_PIXELS = 4000, 400
_APART = 40
"""Least pixels between two lines of the grid."""
_BLANK_RESOLUTION = 0.05  # m
_NO_PILLOW = (
    "the picture is the plain map; the extra cli adds grid, scale, marks, path, scan and robot: "
    'pip install ".[cli]"'
)


def chart_png(grid: GridMap, out: Output, *, marks: bool = True, **what: Any) -> bytes:
    """Return the PNG; print lines for what the picture cannot show.

    Args:
        grid: The map.
        out: Prints the lines.
        marks: Whether to draw the user's marks.
        what: `pose`, `scan`, `path`: see `chart_of`.
    """
    from rosproto.numeric import encode_png

    try:
        pixels, notes = chart_of(grid, marks=MarkFile(mark_file()) if marks else (), **what)
    except ImportError:
        out.line(_NO_PILLOW)
        return encode_png(_grey(grid)[0])
    for note in notes:
        out.line(note)
    return encode_png(pixels)


def chart_of(
    grid: GridMap,
    *,
    pose: Pose2D | None = None,
    scan: NDArray[np.floating] | None = None,
    path: Sequence[Pose2D] = (),
    marks: Iterable[UserMark] = (),
) -> tuple[NDArray[np.uint8], list[str]]:
    """Draw a map with grid and scale, marks (green), path (blue), scan (orange) and robot (red).

    Returns:
        (height, width, 3), and a line for each mark shown by a number, because the font lacks its name.

    Raises:
        ImportError: Pillow is not installed.
    """
    picture = _Picture(grid)
    notes: list[str] = []
    picture.grid_lines()
    for mark in marks:
        if mark.pose is None or not grid.contains(mark.pose.x, mark.pose.y):
            continue
        name = mark.name
        if not (name.isascii() and name.isprintable()):
            name = f"#{len(notes) + 1}"
            notes.append(say("{number} in the picture: {name}", number=name, name=mark.name))
        picture.mark(name, mark.pose)
    picture.line([(each.x, each.y) for each in path], PATH)
    if scan is not None:
        picture.dots(scan, SCAN)
    if pose is not None:
        picture.robot(pose)
    return np.asarray(picture.framed()), notes


def blank_around(points: NDArray[np.floating]) -> GridMap:
    """Return an empty map that contains the points (N, 2) m and the origin, for pictures without a map."""
    corners = np.vstack([np.asarray(points, dtype=np.float64).reshape(-1, 2), [[0.0, 0.0]]])
    low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0  # 1 m around them
    width, height = (math.ceil(float(v) / _BLANK_RESOLUTION) for v in high - low)
    cells = np.zeros((height, width), np.int8)
    return GridMap(cells, _BLANK_RESOLUTION, Pose2D(float(low[0]), float(low[1])))


def step_of(metre: float, apart: float = _APART) -> float:
    """Return the grid spacing in m, 1, 2 or 5 times a power of ten, for `metre` pixels per m."""
    least = apart / metre
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * factor for factor in (1.0, 2.0, 5.0, 10.0) if power * factor >= least * 0.999)


def _grey(grid: GridMap) -> tuple[NDArray[np.uint8], float]:
    """Return (height, width) uint8, north up, and the pixels per m.

    A huge map is subsampled, a small one enlarged.
    """
    longest = max(grid.width, grid.height)
    scale = 1 if longest >= _MIN_PIXELS else min(8, math.ceil(_MIN_PIXELS / longest))
    step = max(1, math.ceil(longest / _MAX_PIXELS))
    grey = grid.to_grey()[::step, ::step]
    return np.repeat(np.repeat(grey, scale, axis=0), scale, axis=1), scale / (grid.resolution * step)


class _Picture:
    """Draws shapes over a map, in m in the map's frame, clipped at its edges."""

    def __init__(self, grid: GridMap) -> None:
        from PIL import Image, ImageDraw, ImageFont

        self._origin = grid.origin
        self._cos, self._sin = math.cos(grid.origin.yaw), math.sin(grid.origin.yaw)
        grey, self._metre = _grey(grid)
        self._light = Image.fromarray(np.where(grey > 128, np.uint8(255), np.uint8(0)))
        self._image = Image.fromarray(grey).convert("RGB")
        self._draw = ImageDraw.Draw(self._image)
        self._font: Any = ImageFont.load_default()
        self._width, self._height = self._image.size
        self._step = step_of(self._metre)

    def grid_lines(self) -> None:
        """Draw thin grid lines on free and unknown cells, not on walls."""
        from PIL import ImageDraw

        layer = self._image.copy()
        draw = ImageDraw.Draw(layer)
        xs, ys = zip(*(self._metres(c, r) for c in (0, self._width) for r in (0, self._height)), strict=True)
        for x in _multiples(self._step, min(xs), max(xs)):
            draw.line([self._pixel(x, min(ys)), self._pixel(x, max(ys))], LINES)
        for y in _multiples(self._step, min(ys), max(ys)):
            draw.line([self._pixel(min(xs), y), self._pixel(max(xs), y)], LINES)
        self._image.paste(layer, mask=self._light)

    def dots(self, points: NDArray[np.floating], color: Color) -> None:
        """Draw points (N, 2) in m as small squares."""
        for x, y in np.asarray(points, dtype=np.float64):
            column, row = self._pixel(x, y)
            if 0 <= column < self._width and 0 <= row < self._height:
                self._draw.rectangle((column - 1, row - 1, column + 1, row + 1), color)

    def line(self, points: Iterable[tuple[float, float]], color: Color) -> None:
        """Draw a line through points in m."""
        corners = [self._pixel(x, y) for x, y in points]
        if len(corners) > 1:
            self._draw.line(corners, color, 3)

    def robot(self, pose: Pose2D, size: float = 0.35) -> None:
        """Draw a circle of `size` m with a line in its heading."""
        column, row = self._pixel(pose.x, pose.y)
        pixels = size * self._metre
        if not (-pixels < column < self._width + pixels and -pixels < row < self._height + pixels):
            return
        box = column - pixels, row - pixels, column + pixels, row + pixels
        self._draw.ellipse(box, outline=ROBOT, width=3)
        tip = (pose.x + 1.6 * size * math.cos(pose.yaw), pose.y + 1.6 * size * math.sin(pose.yaw))
        self.line([(pose.x, pose.y), tip], ROBOT)

    def mark(self, name: str, pose: Pose2D) -> None:
        """Draw a small triangle in the mark's heading, with its name."""
        size = max(0.2, 6.0 / self._metre)
        corners = [(2.0 * size, 0.0), (-size, size), (-size, -size), (2.0 * size, 0.0)]
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        self.line([(pose.x + c * x - s * y, pose.y + s * x + c * y) for x, y in corners], MARK)
        column, row = self._pixel(pose.x, pose.y)
        width, height = self._size(name)
        left, top = column + 2.0 * size * self._metre + 5, row - height / 2
        self._draw.rectangle((left - 2, top - 2, left + width + 2, top + height + 2), PAPER)
        self._draw.text((left, top), name, MARK, self._font)

    def framed(self) -> Image:
        """Add a white margin with the grid's numbers, in m of the map, and a scale bar."""
        from PIL import Image, ImageDraw

        whole = Image.new("RGB", (LEFT + self._width + RIGHT, TOP + self._height + BOTTOM), PAPER)
        draw = ImageDraw.Draw(whole)
        draw.rectangle((LEFT - 1, TOP - 1, LEFT + self._width, TOP + self._height), outline=INK)
        whole.paste(self._image, (LEFT, TOP))
        turned = self._origin.yaw != 0.0
        end = 0.0
        for column, text in sorted(self._crossings(self._cos, self._sin, self._width, turned, "x")):
            width, _ = self._size(text)
            at = LEFT + column
            draw.line((at, TOP + self._height, at, TOP + self._height + 3), INK)
            if end + 4 < at - width / 2 and at + width / 2 < whole.width:
                draw.text((at - width / 2, TOP + self._height + 5), text, INK, self._font)
                end = at + width / 2
        end = TOP + self._height + BOTTOM
        for up, text in sorted(self._crossings(-self._sin, self._cos, self._height, turned, "y")):
            width, height = self._size(text)
            at = TOP + self._height - up
            draw.line((LEFT - 5, at, LEFT - 2, at), INK)
            if at - height / 2 >= 0 and at + height / 2 < end - 3:
                draw.text((max(1, LEFT - 8 - width), at - height / 2), text, INK, self._font)
                end = at - height / 2
        self._scale_bar(draw, whole.height - 10, whole.width)
        return whole

    def _crossings(
        self, x_each: float, y_each: float, pixels: int, turned: bool, along: str
    ) -> Iterator[tuple[float, str]]:
        """Yield pixel positions and numbers of grid lines on an edge that begins at the map's origin.

        Args:
            x_each, y_each: How x and y change with each metre of the edge.
            pixels: Length of the edge.
            turned: Whether lines of both kinds cross it.
            along: The kind that crosses it otherwise.
        """
        for name, begin, each in (("x", self._origin.x, x_each), ("y", self._origin.y, y_each)):
            if abs(each) < 1e-9 or not (turned or name == along):
                continue
            ends = sorted((begin, begin + each * pixels / self._metre))
            for value in _multiples(self._step, *ends):
                yield (value - begin) / each * self._metre, (name if turned else "") + _number(value)

    def _scale_bar(self, draw: Any, row: int, width: int) -> None:
        """Draw a scale bar at the lower left, about an eighth of the picture, with its length in m."""
        length = step_of(self._metre, max(40.0, self._width / 8.0))
        end = LEFT + min(self._width, round(length * self._metre))
        draw.line((LEFT, row, end, row), INK, 2)
        for column in (LEFT, end - 1):
            draw.line((column, row - 5, column, row), INK, 2)
        draw.text((end + 8, row - 10), f"{_number(length)} m", INK, self._font)
        note = "x, y in m"
        left = width - RIGHT - self._size(note)[0]
        if left > end + 70:
            draw.text((left, row - 10), note, INK, self._font)

    def _size(self, text: str) -> tuple[int, int]:
        width, height = self._font.getmask(text).size
        return int(width), int(height)

    def _pixel(self, x: float, y: float) -> tuple[int, int]:
        """Return column and row; points far outside are limited to values that Pillow accepts."""
        dx, dy = x - self._origin.x, y - self._origin.y
        across, up = self._cos * dx + self._sin * dy, self._cos * dy - self._sin * dx
        column, row = across * self._metre, self._height - up * self._metre
        return round(max(-1e6, min(1e6, column))), round(max(-1e6, min(1e6, row)))

    def _metres(self, column: float, row: float) -> tuple[float, float]:
        across, up = column / self._metre, (self._height - row) / self._metre
        x = self._origin.x + self._cos * across - self._sin * up
        return x, self._origin.y + self._sin * across + self._cos * up


def _multiples(step: float, low: float, high: float) -> Iterator[float]:
    """Yield multiples of the step strictly between two values."""
    for number in range(math.floor(low / step) + 1, math.ceil(high / step)):
        yield number * step


def _number(value: float) -> str:
    return f"{value:.6g}" if value else "0"
