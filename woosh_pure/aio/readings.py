"""The feeds of the awaited `Chassis`: those of `woosh_pure.readings`, one by one, with their types."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from woosh_pure.aio.calls import Calls
from woosh_pure.aio.feed import Feed
from woosh_pure.faults.codes import StatusCode
from woosh_pure.geometry import Pose2D, Velocity

if TYPE_CHECKING:
    from woosh_pure import readings, values
    from woosh_pure.feed.feed import Feed as Threaded

__all__ = ["Readings"]

T = TypeVar("T")


class Readings:
    """The part of the awaited `Chassis` that only listens; see there."""

    chassis: readings.Readings
    _calls: Calls

    def feed(self, name: str) -> Feed[Any]:
        """A feed by its name in the interface table, or by its topic: any topic that the chassis publishes.

        Topics without a property of their own give the messages themselves.

        Raises:
            KeyError: It is not in the table; the text lists near names.
            ValueError: It is no topic that the chassis publishes.
        """
        return self._feed(self.chassis.feed(name))

    def _feed(self, feed: Threaded[T]) -> Feed[T]:
        return Feed(feed, self._calls)

    @property
    def status(self) -> Feed[values.RobotStatus]:
        """`/robot_status`, published on change only."""
        return self._feed(self.chassis.status)

    @property
    def pose(self) -> Feed[Pose2D]:
        """`/movebase_pose2d`: map_T_base, m and rad."""
        return self._feed(self.chassis.pose)

    @property
    def odometer(self) -> Feed[float]:
        """`/odometer`: metres travelled."""
        return self._feed(self.chassis.odometer)

    @property
    def battery(self) -> Feed[values.Battery]:
        """`/battery`."""
        return self._feed(self.chassis.battery)

    @property
    def localization(self) -> Feed[values.PoseEstimate]:
        """`/amcl_pose`."""
        return self._feed(self.chassis.localization)

    @property
    def information(self) -> Feed[values.Information]:
        """`/information`."""
        return self._feed(self.chassis.information)

    @property
    def bms(self) -> Feed[values.Bms]:
        """`/driver_base/bms`."""
        return self._feed(self.chassis.bms)

    @property
    def parameters(self) -> Feed[values.Parameters]:
        """`/driver_base/parameter`."""
        return self._feed(self.chassis.parameters)

    @property
    def measured_velocity(self) -> Feed[Velocity]:
        """`/odom_twist`: what the base really does, m/s and rad/s."""
        return self._feed(self.chassis.measured_velocity)

    @property
    def status_code(self) -> Feed[StatusCode]:
        """`/status_code`, decoded; `faults` is the set that is active."""
        return self._feed(self.chassis.status_code)

    @property
    def scan(self) -> Feed[values.LaserScan]:
        """`/scan`."""
        return self._feed(self.chassis.scan)

    @property
    def imu(self) -> Feed[values.Imu]:
        """`/imu/data_raw`."""
        return self._feed(self.chassis.imu)

    @property
    def odometry_raw(self) -> Feed[values.Odometry]:
        """`/odom_raw`: by the wheels alone."""
        return self._feed(self.chassis.odometry_raw)

    @property
    def odometry(self) -> Feed[values.Odometry]:
        """`/odom`: wheels and IMU."""
        return self._feed(self.chassis.odometry)

    @property
    def camera(self) -> Feed[values.Image]:
        """`/camera_1/color/image_raw`."""
        return self._feed(self.chassis.camera)

    @property
    def depth(self) -> Feed[values.Image]:
        """`/camera_1/depth/image_raw`."""
        return self._feed(self.chassis.depth)

    @property
    def points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/points`."""
        return self._feed(self.chassis.points)

    @property
    def obstacle_points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/cloud_without_planes`."""
        return self._feed(self.chassis.obstacle_points)
