"""The name that programs import: all of it is in `woosh_pure.maps.gridmap`."""

from __future__ import annotations

from woosh_pure.maps.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "GridMap"]
