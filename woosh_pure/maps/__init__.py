"""Grid maps with map_server's files, and the user's list of marks."""

from __future__ import annotations

from woosh_pure.maps.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from woosh_pure.maps.marks import MarkFile, UserMark

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "GridMap", "MarkFile", "UserMark"]
