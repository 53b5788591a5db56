"""The chassis's data as values, and conversions between values and messages."""

from __future__ import annotations

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
