"""Maps, marks, and where the robot is in them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.maps.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
    from woosh_pure.maps.marks import MarkFile, UserMark

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "GridMap", "MarkFile", "UserMark"]

__getattr__ = late_names(
    __name__,
    {
        "FREE": "gridmap",
        "GridMap": "gridmap",
        "MarkFile": "marks",
        "OCCUPIED": "gridmap",
        "UNKNOWN": "gridmap",
        "UserMark": "marks",
    },
)
