"""The map of one robot as picture, metadata and YAML, fetched on demand."""

from __future__ import annotations

import hashlib
import threading
import time
from dataclasses import dataclass

from rosproto.errors import RosError
from rosproto.numeric import encode_png
from woosh_pure.chassis import Chassis
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.mapfiles import yaml_of
from woosh_pure.web.snapshot import pose_part

FRESH = 30.0
"""Seconds after which a request fetches the map again."""


@dataclass(frozen=True, slots=True)
class KnownMap:
    """A map with its picture.

    Attributes:
        version: A short text that changes with the content.
        png: Grey picture, north up.
    """

    grid: GridMap
    version: str
    png: bytes

    def as_json(self) -> dict[str, object]:
        """The map's facts as the API sends them; the origin is the lower left corner, in m and rad."""
        grid = self.grid
        return {
            "version": self.version,
            "width": grid.width,
            "height": grid.height,
            "resolution": round(grid.resolution, 6),
            "origin": pose_part(grid.origin),
        }

    def yaml(self) -> str:
        """Return the YAML file for map_server; it names the PNG as its image."""
        return yaml_of("map.png", self.grid.resolution, self.grid.origin)


class MapCache:
    """Fetches and keeps the map. One caller fetches at a time; the others wait for its result. Blocks."""

    def __init__(self, chassis: Chassis) -> None:
        self._chassis = chassis
        self._lock = threading.Lock()
        self._known: KnownMap | None = None
        self._asked = -FRESH
        self._robot: frozenset[str] = frozenset()
        self._error: Exception | None = None

    def get(self) -> KnownMap:
        """Return the map, fetched again if it is old.

        Raises:
            RosError, ValueError: Fetching failed, and there is no older map.
        """
        with self._lock:
            robot = self._chassis.feed("status").sources  # another process after the robot was started again
            if robot != self._robot or time.monotonic() - self._asked > (FRESH if self._known else 2.0):
                self._robot = robot
                self._fetch()
            if self._known is not None:
                return self._known
            assert self._error is not None
            raise self._error

    def _fetch(self) -> None:
        try:
            grid = self._chassis.get_map()
            place = f"{grid.resolution} {grid.origin} {grid.cells.shape}".encode()
            version = hashlib.sha256(place + grid.cells.tobytes()).hexdigest()[:12]
            if self._known is None or self._known.version != version:
                self._known = KnownMap(grid, version, encode_png(grid.to_grey()))
        except (RosError, ValueError) as error:
            self._error = error
        finally:
            self._asked = time.monotonic()
