"""What makes a map picture readable: a grid in metres, its numbers along the edges, a scale bar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from woosh_pure.cli.letters import INK, PAPER, put_text, text_mask

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from woosh_pure.cli.canvas import Picture

__all__ = ["draw_grid", "framed", "step_of"]

LEFT, RIGHT, TOP, BOTTOM = 44, 12, 12, 44
"""Pixels of the margins."""
_GRID = (206, 218, 232)
_APART = 40
"""Least pixels between two lines of the grid."""


def step_of(metre: float, apart: float = _APART) -> float:
    """Metres between two lines, 1, 2 or 5 times a power of ten, when a metre has so many pixels."""
    least = apart / metre
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * factor for factor in (1.0, 2.0, 5.0, 10.0) if power * factor >= least * 0.999)


def _lines(picture: Picture) -> tuple[NDArray[np.int64], NDArray[np.int64], float]:
    """Number of the grid's field in x and in y for each pixel, and its size in m."""
    step = step_of(picture.pixels_per_metre)
    height, width = picture.pixels.shape[:2]
    origin, size = picture.grid.origin, 1.0 / picture.pixels_per_metre
    across = (np.arange(width) + 0.5) * size
    up = (height - np.arange(height) - 0.5) * size
    c, s = math.cos(origin.yaw), math.sin(origin.yaw)
    x = origin.x + c * across[None, :] - s * up[:, None]
    y = origin.y + s * across[None, :] + c * up[:, None]
    return np.floor(x / step).astype(np.int64), np.floor(y / step).astype(np.int64), step


def draw_grid(picture: Picture) -> None:
    """Thin lines on what is free or unknown; walls stay as they are."""
    columns, rows, _ = _lines(picture)
    light = picture.pixels[:, :, 0] > 128
    for fields in (columns, rows):
        line = np.zeros(light.shape, bool)
        line[:, 1:] |= fields[:, 1:] != fields[:, :-1]
        line[:-1, :] |= fields[:-1, :] != fields[1:, :]
        picture.pixels[line & light] = _GRID


def framed(picture: Picture) -> NDArray[np.uint8]:
    """The picture in a white margin with the numbers of the grid, in m of the map, and a scale bar."""
    height, width = picture.pixels.shape[:2]
    whole = np.full((TOP + height + BOTTOM, LEFT + width + RIGHT, 3), PAPER, np.uint8)
    whole[TOP - 1 : TOP + height + 1, LEFT - 1 : LEFT + width + 1] = INK
    whole[TOP : TOP + height, LEFT : LEFT + width] = picture.pixels
    columns, rows, step = _lines(picture)
    turned = picture.grid.origin.yaw != 0.0
    for name, fields in (("x", columns), ("y", rows)):
        head = name if turned else ""
        _label_bottom(whole, fields[-1], step, head, height) if turned or name == "x" else None
        _label_left(whole, fields[:, 0], step, head) if turned or name == "y" else None
    _scale_bar(whole, picture.pixels_per_metre, width)
    return whole


def _label_bottom(
    whole: NDArray[np.uint8], fields: NDArray[np.int64], step: float, head: str, height: int
) -> None:
    end = -1
    for at in np.flatnonzero(fields[1:] != fields[:-1]) + 1:
        text = head + _number(max(fields[at], fields[at - 1]) * step)
        column, mask = LEFT + int(at), text_mask(text)
        whole[TOP + height : TOP + height + 4, column] = INK
        left = column - mask.shape[1] // 2
        if left > end + 4 and left >= 0 and left + mask.shape[1] < whole.shape[1]:
            put_text(whole, text, left, TOP + height + 7)
            end = left + mask.shape[1]


def _label_left(whole: NDArray[np.uint8], fields: NDArray[np.int64], step: float, head: str) -> None:
    end = -1
    for at in np.flatnonzero(fields[1:] != fields[:-1]) + 1:
        text = head + _number(max(fields[at], fields[at - 1]) * step)
        row, mask = TOP + int(at), text_mask(text)
        whole[row, LEFT - 5 : LEFT - 1] = INK
        top = row - mask.shape[0] // 2
        if top > end + 3 and top >= 0:
            put_text(whole, text, max(1, LEFT - 8 - mask.shape[1]), top)
            end = top + mask.shape[0]


def _number(value: float) -> str:
    return f"{value:.6g}" if value else "0"


def _scale_bar(whole: NDArray[np.uint8], metre: float, width: int) -> None:
    """About a fifth of the picture, at the lower left, with its length in m."""
    length = step_of(metre, max(40.0, width / 8.0))
    pixels = min(width, round(length * metre))
    row = whole.shape[0] - 10
    whole[row - 1 : row + 1, LEFT : LEFT + pixels] = INK
    for column in (LEFT, LEFT + pixels - 1):
        whole[row - 5 : row + 1, column : column + 2] = INK
    put_text(whole, f"{_number(length)} m", LEFT + pixels + 8, row - 8)
    note = "x, y in m"
    left = whole.shape[1] - RIGHT - text_mask(note).shape[1]
    if left > LEFT + pixels + 70:
        put_text(whole, note, left, row - 8)
