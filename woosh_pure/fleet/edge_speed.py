"""Whether a drive keeps to the maxSpeed of its edge. Pure."""

from __future__ import annotations

import math

from woosh_pure.fleet.order.events import Drive

_SLOWING_SECONDS = 2.0  # from the start of a drive, for the robot to slow down to the speed of its edge
_EXCEEDED_SECONDS = 0.3  # before a drive counts as too fast
_FACTOR, _MARGIN = 1.1, 0.05  # overshoot of the controller that is tolerated: of the limit, and m/s


def speed_above_limit(drive: Drive | None, velocity: tuple[float, float, float] | None) -> float:
    """The speed in m/s if it exceeds the maxSpeed of the edge, else 0.

    Args:
        drive: The drive under way.
        velocity: vx, vy in m/s, wz in rad/s; None if it is not known.
    """
    limit = 0.0 if drive is None or drive.edge is None else float(drive.edge.options.get("maxSpeed", 0.0))
    speed = 0.0 if velocity is None else math.hypot(velocity[0], velocity[1])
    return speed if limit and speed > _FACTOR * limit + _MARGIN else 0.0


class EdgeSpeedMonitor:
    """Detects drives that stay above the maxSpeed of their edge."""

    def __init__(self) -> None:
        self._began = 0.0
        self._above_since: float | None = None

    @property
    def above_limit(self) -> bool:
        """Whether the last check found the speed above the limit."""
        return self._above_since is not None

    def drive_began(self, now: float) -> None:
        """Start the time in which the robot may slow down; `now` is monotonic."""
        self._began = now

    def check(
        self, drive: Drive | None, velocity: tuple[float, float, float] | None, now: float
    ) -> str | None:
        """Return what is wrong if the drive has been too fast for too long, else None."""
        speed = speed_above_limit(drive, velocity)
        if not speed:
            self._above_since = None
            return None
        if self._above_since is None:
            self._above_since = max(now, self._began + _SLOWING_SECONDS)
        if now - self._above_since < _EXCEEDED_SECONDS:
            return None
        assert drive is not None
        assert drive.edge is not None
        limit = drive.edge.options["maxSpeed"]
        return f"it drove at {speed:.2f} m/s, and edge {drive.edge.id} allows {limit:g} m/s; it is halted"
