"""A snapshot of what is known of a chassis, for a screen or a picture."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from woosh_pure.readings import known_path, scan_in_map

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from woosh_pure.chassis import Chassis
    from woosh_pure.faults.codes import StatusCode
    from woosh_pure.geometry import Pose2D, Velocity
    from woosh_pure.maps.gridmap import GridMap
    from woosh_pure.reasons import Readiness
    from woosh_pure.values.state import Battery, RobotStatus

__all__ = ["Observer", "Scene"]

FEEDS = ("pose", "velocity", "scan", "battery", "status", "plan", "localization", "odometer")


_SILENT = 2.0


@dataclass(slots=True)
class Scene:
    """One moment; None and empty where nothing was heard.

    Attributes:
        scan: (N, 2) m in the map, or in base_link when the pose is not known.
        rates: Messages per second of each feed that was heard.
        ages: Seconds since the newest message of each feed that was heard.
    """

    master_uri: str
    pose: Pose2D | None = None
    velocity: Velocity | None = None
    battery: Battery | None = None
    status: RobotStatus | None = None
    readiness: Readiness | None = None
    faults: tuple[StatusCode, ...] = ()
    scan: NDArray[np.floating] | None = None
    nearest: float | None = None
    path: Sequence[Pose2D] = ()
    odometer: float | None = None
    grid: GridMap | None = None
    rates: dict[str, float] = field(default_factory=dict)
    ages: dict[str, float] = field(default_factory=dict)

    @property
    def silence(self) -> float | None:
        """Seconds for which nothing at all was heard, when it is longer than a living chassis is silent."""
        least = min(self.ages.values(), default=0.0)
        return least if least > _SILENT else None


class Observer:
    """Looks at a chassis again and again. Opens the feeds at once; the map is fetched by `fetch_map`."""

    def __init__(self, chassis: Chassis) -> None:
        self._chassis = chassis
        self._feeds = {name: chassis.feed(name).open() for name in (*FEEDS, "tf_static")}
        chassis.readiness()
        self._counts: deque[tuple[float, dict[str, int]]] = deque(maxlen=100)
        self.grid: GridMap | None = None

    def fetch_map(self) -> None:
        """Ask for the map; without one, nothing is drawn under the scan."""
        try:
            self.grid = self._chassis.get_map()
        except (RosError, ValueError):
            self.grid = None

    def look(self) -> Scene:
        """What is known now."""
        chassis, feeds = self._chassis, self._feeds
        pose, scan = feeds["pose"].latest, feeds["scan"].latest
        return Scene(
            master_uri=chassis.master_uri,
            pose=pose,
            velocity=feeds["velocity"].latest,
            battery=feeds["battery"].latest,
            status=feeds["status"].latest,
            readiness=chassis.readiness(),
            faults=chassis.faults,
            scan=None if scan is None else scan_in_map(chassis, scan, pose),
            nearest=None if scan is None else scan.nearest,
            path=known_path(chassis),
            odometer=feeds["odometer"].latest,
            grid=self.grid,
            rates=self._rates(),
            ages={name: f.age for name, f in feeds.items() if name in FEEDS and f.age is not None},
        )

    def _rates(self) -> dict[str, float]:
        """Over the last two seconds."""
        now, counts = time.monotonic(), {name: self._feeds[name].count for name in FEEDS}
        self._counts.append((now, counts))
        while len(self._counts) > 2 and now - self._counts[0][0] > 2.0:
            self._counts.popleft()
        since, before = self._counts[0]
        seconds = max(now - since, 1e-3)
        return {name: (count - before[name]) / seconds for name, count in counts.items() if count}
