"""A map picture as a file: grid, scale, the user's marks, and what is known of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from woosh_pure.cli import config
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.maps.gridmap import GridMap

__all__ = ["chart_png"]


def chart_png(grid: GridMap, out: Output, *, marks: bool = True, **what: Any) -> bytes:
    """The PNG; names that the picture cannot show are printed as lines.

    Args:
        grid: The map.
        out: For those lines.
        marks: The marks of the user's list, too.
        what: `pose`, `scan`, `path`: see `chart_of`.
    """
    from rosproto.numeric import encode_png
    from woosh_pure.cli.picture import chart_of
    from woosh_pure.maps.marks import MarkFile

    known = MarkFile(config.mark_file()) if marks else ()
    pixels, notes = chart_of(grid, marks=known, **what)
    for note in notes:
        out.line(note)
    return encode_png(pixels)
