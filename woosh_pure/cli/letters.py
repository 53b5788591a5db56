"""Letters for pictures, five dots high: enough for axes, names of marks and a scale, without a font file.

Small letters are drawn as capitals.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["INK", "PAPER", "can_draw", "put_text", "text_mask"]

INK, PAPER = (40, 50, 60), (255, 255, 255)
"""Colours of letters, and of what is below them."""

HEIGHT = 5
_GLYPHS = {
    name: rows.split("/")
    for name, rows in (
        pair.split(" ")
        for pair in """\
0 ###/#.#/#.#/#.#/###|1 .#/##/.#/.#/.#|2 ###/..#/###/#../###|3 ###/..#/.##/..#/###|4 #.#/#.#/###/..#/..#
5 ###/#../###/..#/###|6 ###/#../###/#.#/###|7 ###/..#/.#./.#./.#.|8 ###/#.#/###/#.#/###|9 ###/#.#/###/..#/###
A .#./#.#/###/#.#/#.#|B ##./#.#/##./#.#/##.|C .##/#../#../#../.##|D ##./#.#/#.#/#.#/##.|E ###/#../##./#../###
F ###/#../##./#../#..|G .###/#.../#.##/#..#/.###|H #.#/#.#/###/#.#/#.#|I #/#/#/#/#|J ..#/..#/..#/#.#/.#.
K #.#/#.#/##./#.#/#.#|L #../#../#../#../###|M #...#/##.##/#.#.#/#...#/#...#|N #..#/##.#/#.##/#..#/#..#
O .##./#..#/#..#/#..#/.##.|P ##./#.#/##./#../#..|Q .##./#..#/#..#/#.##/.###|R ##./#.#/##./#.#/#.#
S .##/#../.#./..#/##.|T ###/.#./.#./.#./.#.|U #.#/#.#/#.#/#.#/###|V #.#/#.#/#.#/#.#/.#.
W #...#/#...#/#.#.#/##.##/#...#|X #.#/#.#/.#./#.#/#.#|Y #.#/#.#/.#./.#./.#.|Z ###/..#/.#./#../###
- .../.../###/.../...|+ .../.#./###/.#./...|. ././././#|, ../../../.#/#.|: ./#/./#/.|_ .../.../.../.../###
/ ..#/..#/.#./#../#..|# .#.#./#####/.#.#./#####/.#.#.|( .#/#./#./#./.#|) #./.#/.#/.#/#.|= .../###/.../###/...
' #/#/././.|? ###/..#/.#./.../.#.|! #/#/#/./#|* .../#.#/.#./#.#/...|% #.#/..#/.#./#../#.#\
""".replace("\n", "|").split("|")
    )
}
_BLANK = ["..", "..", "..", "..", ".."]


def can_draw(text: str) -> bool:
    """Whether there is a letter for every character."""
    return all(c == " " or c.upper() in _GLYPHS for c in text)


def text_mask(text: str, size: int = 2) -> NDArray[np.bool_]:
    """(5 size, width) bool: the dots of a line of text; what has no letter is a question mark.

    Args:
        text: Any.
        size: Pixels of a dot.
    """
    rows: list[list[bool]] = [[] for _ in range(HEIGHT)]
    for character in text:
        glyph = _BLANK if character == " " else _GLYPHS.get(character.upper(), _GLYPHS["?"])
        for row, dots in zip(rows, glyph, strict=False):
            row.extend([dot == "#" for dot in dots] + [False])
    mask = np.array([row[:-1] or [False] for row in rows], bool)
    return np.repeat(np.repeat(mask, size, axis=0), size, axis=1)


def put_text(
    pixels: NDArray[np.uint8],
    text: str,
    left: int,
    top: int,
    color: tuple[int, int, int] = INK,
    *,
    on_paper: bool = False,
) -> None:
    """Write into a picture; what lies outside is cut off.

    Args:
        pixels: (height, width, 3), changed.
        text: One line.
        left, top: Of its upper left corner, pixels.
        color: Of the letters.
        on_paper: A white box below them, for what stands on a map.
    """
    mask = text_mask(text)
    if on_paper:
        mask = np.pad(mask, 2)
        left, top = left - 2, top - 2
    height, width = pixels.shape[:2]
    y0, x0 = max(0, top), max(0, left)
    part = mask[y0 - top : max(0, height - top), x0 - left : max(0, width - left)]
    target = pixels[y0 : y0 + part.shape[0], x0 : x0 + part.shape[1]]
    if on_paper:
        target[:] = PAPER
    target[part] = color
