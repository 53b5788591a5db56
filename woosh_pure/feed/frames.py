"""Scan and path where they belong: as points of the robot, or of the map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from woosh_pure.chassis import Chassis
    from woosh_pure.geometry import Pose2D
    from woosh_pure.values.state import LaserScan

__all__ = ["in_base", "known_path", "scan_in_base", "scan_in_map"]


def known_path(chassis: Chassis) -> list[Pose2D]:
    """The path being driven, as the navigation published it last; empty when nothing was heard."""
    from woosh_pure.values.poses import pose_of

    message = chassis.feed("plan").latest
    if message is None:
        return []
    return [pose_of(p.pose, p.header.frame_id or "map") for p in message.poses]


def scan_in_map(chassis: Chassis, scan: LaserScan, pose: Pose2D | None) -> NDArray[np.floating]:
    """(N, 2) points of a scan, m in the map; in base_link when the pose is not known."""
    import numpy as np

    points = scan_in_base(chassis, scan)
    if pose is None:
        return points
    c, s = np.cos(pose.yaw), np.sin(pose.yaw)
    turned: NDArray[np.floating] = points @ np.array([[c, s], [-s, c]]) + np.array([pose.x, pose.y])
    return turned


def scan_in_base(chassis: Chassis, scan: LaserScan) -> NDArray[np.floating]:
    """(N, 2) points of a scan, m in base_link by the fixed transforms; as they are where none is known."""
    import numpy as np

    flat = scan.points().astype(np.float64)
    points = np.hstack([flat, np.zeros((len(flat), 1))])
    result: NDArray[np.floating] = in_base(chassis, points, scan.frame)[:, :2]
    return result


def in_base(chassis: Chassis, points: NDArray[np.float64], frame: str) -> NDArray[np.float64]:
    """(N, 3) points of a frame, m in base_link by the fixed transforms; as they are where none is known."""
    import numpy as np

    links = _fixed_links(chassis)
    frame = frame.lstrip("/")
    for _ in range(20):  # a loop in the tree must not hold us
        if frame in ("base_link", "base_footprint") or frame not in links:
            break
        frame, transform = links[frame]
        points = _turned(points, transform.rotation)
        t = transform.translation
        points = points + np.array([t.x, t.y, t.z])
    return points


def _fixed_links(chassis: Chassis) -> dict[str, tuple[str, Any]]:
    links: dict[str, tuple[str, Any]] = {}
    for reading in chassis.feed("tf_static").history:
        for link in reading.message.transforms:
            links[link.child_frame_id.lstrip("/")] = (link.header.frame_id.lstrip("/"), link.transform)
    return links


def _turned(points: NDArray[np.float64], q: Any) -> NDArray[np.float64]:
    """Rotated by a unit quaternion; a lidar that hangs upside down is one of the reasons for all of it."""
    import numpy as np

    axis = np.array([q.x, q.y, q.z])
    around = 2.0 * np.cross(axis, points)
    turned: NDArray[np.float64] = points + q.w * around + np.cross(axis, around)
    return turned
