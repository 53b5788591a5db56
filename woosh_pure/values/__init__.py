"""What the chassis says as values, and both ways between values and messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from woosh_pure.values.state import (
        Battery,
        Bms,
        Image,
        Imu,
        Information,
        LaserScan,
        Odometry,
        Parameters,
        PointCloud,
        PoseEstimate,
        RobotStatus,
    )

__all__ = [
    "Battery",
    "Bms",
    "Image",
    "Imu",
    "Information",
    "LaserScan",
    "Odometry",
    "Parameters",
    "PointCloud",
    "PoseEstimate",
    "RobotStatus",
]


def __getattr__(name: str) -> object:
    """Its values when asked for: eleven classes, which those who only need poses do without."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from woosh_pure.values import state

    return getattr(state, name)
