"""The feeds of `Chassis`: one property for each topic on the vendor's page that can be read.

Below them: scans and paths as points of the robot, or of the map.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosproto.coercion import require_callback
from rosproto.errors import RosError
from rosproto.sentence import say
from rosproto.transport import Deadline
from woosh_pure import interface, values
from woosh_pure.components import Components
from woosh_pure.faults import Faults, StatusCode
from woosh_pure.feed.feed import Feed, Reading, call_back
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.values.messages import pose_of
from woosh_pure.values.state import LaserScan

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.tf import Transform

SILENT_SECONDS = 2.0
"""For how long `/odom_twist`, sent many times a second, may be silent while the chassis is connected."""


class Readings:
    """The part of `Chassis` that only listens."""

    _components: Components

    def feed(self, name: str) -> Feed[Any]:
        """A feed by its name in the interface table or by its topic; works for every topic of the chassis.

        A topic without a property of its own yields the messages themselves.

        Raises:
            KeyError: It is not in the table; the text lists similar names.
            ValueError: It is not a topic that the chassis publishes.
        """
        found = interface.row(name) if name.startswith("/") else interface.find(name)
        if found.flow != "read":
            wrong = "{name} is a {kind} to {flow}, not a topic to read"
            raise ValueError(say(wrong, name=found.name, kind=found.kind, flow=found.flow))
        return self._components.feeds.get(found.feed or found.name)

    @property
    def status(self) -> Feed[values.RobotStatus]:
        """`/robot_status`, published on change only."""
        return self._components.feeds.get("status")

    @property
    def pose(self) -> Feed[Pose2D]:
        """`/movebase_pose2d`: map_T_base, m and rad."""
        return self._components.feeds.get("pose")

    @property
    def odometer(self) -> Feed[float]:
        """`/odometer`: metres travelled."""
        return self._components.feeds.get("odometer")

    @property
    def battery(self) -> Feed[values.Battery]:
        """`/battery`: charge in %, voltage, current, temperatures, capacities; V, A, °C, Ah."""
        return self._components.feeds.get("battery")

    @property
    def localization(self) -> Feed[values.PoseEstimate]:
        """`/amcl_pose`: the pose found by the localisation, with its covariance; m and rad in the map."""
        return self._components.feeds.get("localization")

    @property
    def information(self) -> Feed[values.Information]:
        """`/information`: versions of the controller, type of the base, parameters."""
        return self._components.feeds.get("information")

    @property
    def bms(self) -> Feed[values.Bms]:
        """`/driver_base/bms`: what the battery management system measures; V, A, °C, Ah."""
        return self._components.feeds.get("bms")

    @property
    def parameters(self) -> Feed[values.Parameters]:
        """`/driver_base/parameter`: wheel geometry, reduction ratios, speed limits; m, m/s, rad/s."""
        return self._components.feeds.get("parameters")

    @property
    def measured_velocity(self) -> Feed[Velocity]:
        """`/odom_twist`: how the base actually moves, m/s and rad/s."""
        return self._components.feeds.get("velocity")

    @property
    def status_code(self) -> Feed[StatusCode]:
        """`/status_code`, decoded; `faults` is the set that is active."""
        return self._components.feeds.get("status_code")

    @property
    def scan(self) -> Feed[values.LaserScan]:
        """`/scan`: the fused lidar scan; m and rad in the scan's own frame."""
        return self._components.feeds.get("scan")

    @property
    def imu(self) -> Feed[values.Imu]:
        """`/imu/data_raw`: raw inertial measurements; rad/s and m/s² in the IMU's frame."""
        return self._components.feeds.get("imu")

    @property
    def odometry_raw(self) -> Feed[values.Odometry]:
        """`/odom_raw`: from the wheels alone."""
        return self._components.feeds.get("odometry_raw")

    @property
    def odometry(self) -> Feed[values.Odometry]:
        """`/odom`: from wheels and IMU."""
        return self._components.feeds.get("odometry")

    @property
    def camera(self) -> Feed[values.Image]:
        """`/camera_1/color/image_raw`: the colour image, as an array of pixels."""
        return self._components.feeds.get("camera")

    @property
    def depth(self) -> Feed[values.Image]:
        """`/camera_1/depth/image_raw`: the depth image, as an array; m or mm, by its encoding."""
        return self._components.feeds.get("depth")

    @property
    def points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/points`: the depth image as a point cloud; m in the camera's frame."""
        return self._components.feeds.get("points")

    @property
    def obstacle_points(self) -> Feed[values.PointCloud]:
        """`/camera_1/depth/cloud_without_planes`: points of obstacles, no ground; m, camera frame."""
        return self._components.feeds.get("obstacle_points")

    @property
    def faults(self) -> Faults:
        """The active faults, the worst first: a tuple of those heard since this was first read.

        An empty tuple does not mean that there are none: `known` says whether the robot reports that there
        are no others, and `sentence()` returns all of this as text.
        """
        return self._components.readiness_state.active_faults()

    @property
    def connected(self) -> bool:
        """Whether the chassis is heard: `/odom_twist`, which it always sends, is linked and not silent.

        While nothing was heard yet it waits, half a second at most once our node is there.
        """
        feed = self.measured_velocity
        try:
            if feed.known is None:
                feed.wait(0.5, new=False)
        except RosError:
            return False
        newest = feed.known
        return bool(feed.links) and newest is not None and newest.age < SILENT_SECONDS

    def on_connection(self, callback: Callable[[bool], object]) -> Callable[[], None]:
        """Call `callback(connected)` at once, and whenever it changes; returns a function that ends this.

        It is called in a thread of its own, named `woosh:connection`, at last with False when the Chassis is
        closed. An exception in it is logged with its traceback.
        """
        require_callback(callback)
        over = threading.Event()

        def watch() -> None:
            known: bool | None = None
            while not over.is_set():
                closed = self.measured_velocity.closed
                if (now := self.connected) is not known and not over.is_set():
                    known = now
                    call_back(callback, now, "connection")
                if closed or over.wait(0.1):
                    return

        threading.Thread(target=watch, name="woosh:connection", daemon=True).start()
        return over.set

    def snapshot(self, timeout: float = 0.0) -> dict[str, Reading[Any] | None]:
        """The newest reading of every feed on the vendor's page, None where nothing was received.

        Args:
            timeout: Seconds to wait for feeds that have been silent so far. Cameras are included only if they
                were opened before, because their messages are large.
        """
        heavy = {"camera", "depth", "points", "obstacle_points"}
        opened = self._components.feeds.opened
        names = [
            r.feed
            for r in interface.feeds()
            if r.source == "page" and (r.feed not in heavy or r.feed in opened)
        ]
        feeds = {name: self._components.feeds.get(name).open() for name in names}
        deadline = Deadline(timeout)
        while not deadline.expired and not all(f.heard or f.row.on_change for f in feeds.values()):
            time.sleep(0.02)
        return {name: feed.reading for name, feed in feeds.items()}


# -- scan and path in base_link or in the map ----------------------------------------------------------------


def known_path(chassis: Readings) -> list[Pose2D]:
    """The path being driven, as the navigation published it last; empty when none was received."""
    message = chassis.feed("plan").latest
    if message is None:
        return []
    return [pose_of(p.pose, p.header.frame_id or "map") for p in message.poses]


def scan_in_map(chassis: Readings, scan: LaserScan, pose: Pose2D | None) -> NDArray[np.floating]:
    """(N, 2) points of a scan, m in the map; in base_link when the pose is not known."""
    import numpy as np

    points = scan_in_base(chassis, scan)
    if pose is None:
        return points
    c, s = np.cos(pose.yaw), np.sin(pose.yaw)
    turned: NDArray[np.floating] = points @ np.array([[c, s], [-s, c]]) + np.array([pose.x, pose.y])
    return turned


def scan_in_base(chassis: Readings, scan: LaserScan) -> NDArray[np.floating]:
    """(N, 2) points of a scan, m in base_link by the fixed transforms; unchanged where none is known."""
    import numpy as np

    flat = scan.points().astype(np.float64)
    points = np.hstack([flat, np.zeros((len(flat), 1))])
    result: NDArray[np.floating] = in_base(chassis, points, scan.frame)[:, :2]
    return result


def in_base(chassis: Readings, points: NDArray[np.float64], frame: str) -> NDArray[np.float64]:
    """(N, 3) points of a frame, m in base_link by the fixed transforms; unchanged where none is known."""
    links = _fixed_links(chassis)
    frame = frame.lstrip("/")
    for _ in range(20):  # the tree may contain a loop
        if frame in ("base_link", "base_footprint") or frame not in links:
            break
        points, frame = links[frame].points(points), links[frame].target
    return points


def _fixed_links(chassis: Readings) -> dict[str, Transform]:
    """The transform of each frame to its parent."""
    from rosproto.tf import Transform

    links = (link for reading in chassis.feed("tf_static").history for link in reading.message.transforms)
    return {link.source: link for link in map(Transform.from_message, links)}


def free_ways(points: NDArray[np.floating], width: float) -> dict[str, float]:
    """Return the distance in m from base_link to the first obstacle, in its four directions.

    Only points in a lane of `width` count: a wall beside the robot is not ahead.

    Args:
        points: (N, 2) m in base_link.
        width: Width of the lane, m.
    """
    found = {}
    for name, along, across in (
        ("ahead", points[:, 0], points[:, 1]),
        ("left", points[:, 1], points[:, 0]),
        ("right", -points[:, 1], points[:, 0]),
        ("behind", -points[:, 0], points[:, 1]),
    ):
        here = along[(along > 0.0) & (abs(across) <= width / 2.0)]
        found[name] = float(here.min()) if here.size else math.inf
    return found


def nearest_of(points: NDArray[np.floating]) -> tuple[float, float] | None:
    """Return distance (m) and direction (degrees, 0 ahead, left positive) of the nearest point."""
    import numpy as np

    if not len(points):
        return None
    distances = np.hypot(points[:, 0], points[:, 1])
    x, y = points[int(distances.argmin())]
    return float(distances.min()), math.degrees(math.atan2(y, x))


def side_of(degrees: float) -> str:
    """Return the robot's side in a direction."""
    sides = ("ahead", "ahead left", "left", "behind left", "behind", "behind right", "right", "ahead right")
    return sides[round(degrees / 45.0) % 8]
