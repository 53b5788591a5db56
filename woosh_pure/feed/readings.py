"""The feeds of `Chassis`: one property for each topic on the vendor's page that can be read."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from rosproto.transport import Deadline
from woosh_pure import interface
from woosh_pure.core import Core
from woosh_pure.faults.codes import Faults, StatusCode
from woosh_pure.feed.feed import Feed, Reading
from woosh_pure.geometry import Pose2D, Velocity

if TYPE_CHECKING:
    from woosh_pure import values

__all__ = ["Readings"]


class Readings:
    """The part of `Chassis` that only listens."""

    _core: Core

    def feed(self, name: str) -> Feed[Any]:
        """A feed by its name in the interface table or by its topic; works for every topic of the chassis.

        A topic without a property of its own yields the messages themselves.

        Raises:
            KeyError: It is not in the table; the text lists similar names.
            ValueError: It is no topic that the chassis publishes.
        """
        found = interface.row(name) if name.startswith("/") else interface.find(name)
        if found.flow != "read":
            raise ValueError(f"{found.name} is a {found.kind} to {found.flow}, not a topic to read")
        return self._core.feeds.get(found.feed or found.name)

    @property
    def status(self) -> Feed[values.RobotStatus]:
        """`/robot_status`, published on change only."""
        return self._core.feeds.get("status")

    @property
    def pose(self) -> Feed[Pose2D]:
        """`/movebase_pose2d`: map_T_base, m and rad."""
        return self._core.feeds.get("pose")

    @property
    def odometer(self) -> Feed[float]:
        """`/odometer`: metres travelled."""
        return self._core.feeds.get("odometer")

    @property
    def battery(self) -> Feed[values.Battery]:
        """`/battery`."""
        return self._core.feeds.get("battery")

    @property
    def localization(self) -> Feed[values.PoseEstimate]:
        """`/amcl_pose`."""
        return self._core.feeds.get("localization")

    @property
    def information(self) -> Feed[values.Information]:
        """`/information`."""
        return self._core.feeds.get("information")

    @property
    def bms(self) -> Feed[values.Bms]:
        """`/driver_base/bms`."""
        return self._core.feeds.get("bms")

    @property
    def parameters(self) -> Feed[values.Parameters]:
        """`/driver_base/parameter`."""
        return self._core.feeds.get("parameters")

    @property
    def measured_velocity(self) -> Feed[Velocity]:
        """`/odom_twist`: how the base actually moves, m/s and rad/s."""
        return self._core.feeds.get("velocity")

    @property
    def status_code(self) -> Feed[StatusCode]:
        """`/status_code`, decoded; `faults` is the set that is active."""
        return self._core.feeds.get("status_code")

    @property
    def scan(self) -> Feed[values.LaserScan]:
        """`/scan`."""
        return self._core.feeds.get("scan")

    @property
    def imu(self) -> Feed[values.Imu]:
        """`/imu/data_raw`."""
        return self._core.feeds.get("imu")

    @property
    def odometry_raw(self) -> Feed[values.Odometry]:
        """`/odom_raw`: from the wheels alone."""
        return self._core.feeds.get("odometry_raw")

    @property
    def odometry(self) -> Feed[values.Odometry]:
        """`/odom`: from wheels and IMU."""
        return self._core.feeds.get("odometry")

    @property
    def camera(self) -> Feed[values.Image]:
        """`/camera_1/color/image_raw`."""
        return self._core.feeds.get("camera")

    @property
    def depth(self) -> Feed[values.Image]:
        """`/camera_1/depth/image_raw`."""
        return self._core.feeds.get("depth")

    @property
    def points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/points`."""
        return self._core.feeds.get("points")

    @property
    def obstacle_points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/cloud_without_planes`."""
        return self._core.feeds.get("obstacle_points")

    @property
    def faults(self) -> Faults:
        """The active faults, the worst first: a tuple of those heard since this was first read.

        An empty tuple does not mean that there are none: `known` says whether the robot itself reports that
        there is nothing else, and `sentence()` says all of it in words.
        """
        return self._core.knowledge.active_faults()

    def snapshot(self, timeout: float = 0.0) -> dict[str, Reading[Any] | None]:
        """The newest reading of every feed on the vendor's page, None where nothing was heard.

        Args:
            timeout: Seconds to wait for feeds that have been silent so far. Cameras are included only if they
                were opened before, because their messages are large.
        """
        heavy = {"camera", "depth", "points", "obstacle_points"}
        opened = self._core.feeds.opened
        names = [
            r.feed
            for r in interface.feeds()
            if r.source == "page" and (r.feed not in heavy or r.feed in opened)
        ]
        feeds = {name: self._core.feeds.get(name).open() for name in names}
        deadline = Deadline(timeout)
        while not deadline.expired and not all(f.heard or f.row.on_change for f in feeds.values()):
            time.sleep(0.02)
        return {name: feed.reading for name, feed in feeds.items()}
