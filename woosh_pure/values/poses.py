"""Poses of messages as values, for those who need nothing else of `convert`."""

from __future__ import annotations

from typing import Any

from woosh_pure.geometry import Pose2D, yaw_from_quaternion

__all__ = ["pose_of"]


def pose_of(pose: Any, frame: str, child: str = "base_link") -> Pose2D:
    """geometry_msgs/Pose to a `Pose2D`; height, roll and pitch are left out."""
    q = pose.orientation
    return Pose2D(
        pose.position.x, pose.position.y, yaw_from_quaternion(q.x, q.y, q.z, q.w), frame.lstrip("/"), child
    )
