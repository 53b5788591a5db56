"""The chassis's data as values: SI units, enums, numpy arrays. Made from messages by
`woosh_pure.values.convert`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.sentence import say
from woosh_pure.enums import (
    ActionState,
    ActionType,
    ChargeMode,
    ChargeStatus,
    RobotMode,
    RobotState,
    TaskState,
    TaskType,
    WorkMode,
)
from woosh_pure.geometry import Pose2D, Velocity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class RobotStatus:
    """/robot_status, published on change only.

    Attributes:
        task_id, task_type, task_state: The running task, or the last one.
        action_type, action_state: What it is doing.
        robot_state, robot_mode, work_mode: State of the robot.
        wait_id: Number of the wait a task is in.
        destination: Mark or place the task goes to.
        message: The chassis's own words.
        updated: Last update by the chassis's clock, s.
    """

    task_id: int
    task_type: TaskType
    task_state: TaskState
    action_type: ActionType
    action_state: ActionState
    robot_state: RobotState
    robot_mode: RobotMode
    work_mode: WorkMode
    wait_id: int
    destination: str
    message: str
    updated: int


@dataclass(frozen=True, slots=True)
class Battery:
    """/battery. Units: V, A, °C, Ah; `time_remaining` is passed on as it comes (the page gives no unit).

    The Robot API tells no voltages, currents, capacities and times: they are NaN, and `measured` is false.
    """

    percent: int
    charge_mode: ChargeMode
    charge_status: ChargeStatus
    voltage: float
    current: float
    time_remaining: float
    temperature_max: int
    temperature_min: int
    capacity_remaining: float
    capacity_full: float
    capacity_design: float
    charge_cycles: int
    battery_cycles: int
    cell_voltage_max: float
    cell_voltage_min: float
    bms_status: int
    submodule: int = 0

    @property
    def measured(self) -> bool:
        """Whether voltage, current and capacity are known."""
        return not math.isnan(self.voltage)

    @property
    def charging(self) -> bool:
        """True while current flows in."""
        return self.charge_status is ChargeStatus.CHARGING


@dataclass(frozen=True, slots=True)
class Bms:
    """/driver_base/bms. Units: A, V, °C, Ah."""

    status: int
    current: float
    cell_voltage_max: float
    cell_voltage_min: float
    voltage: float
    temperature_max: float
    temperature_min: float
    charge_cycles: int
    capacity_remaining: float
    capacity_full: float
    switch_status: int


@dataclass(frozen=True, slots=True)
class Parameters:
    """/driver_base/parameter, passed on as it comes: the vendor gives no units.

    Assumed: wheels in m, `max_linear` and the joystick's in m/s, `max_angular` in rad/s. `max_rpm` is in
    1/min; `min_speed` and `max_speed` are speeds of rotation by the vendor's words. 0: no such limit.
    """

    wheel_perimeter: float
    wheel_distance: float
    ratio_left: float
    ratio_right: float
    pulses_per_turn: int
    max_rpm: float
    min_speed: float
    max_speed: float
    max_linear: float
    max_angular: float
    joystick_max_linear: float
    joystick_max_angular: float


@dataclass(frozen=True, slots=True)
class Information:
    """/information: versions and parameters of the motion controller."""

    hardware_version: str
    software_version: str
    bootloader_version: str
    base_type: str
    parameters: Parameters


@dataclass(frozen=True, slots=True)
class PoseEstimate:
    """/amcl_pose: pose with covariance (6, 6) float64 over x, y, z, roll, pitch, yaw; a view of the
    message."""

    pose: Pose2D
    covariance: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Odometry:
    """/odom, /odom_raw: pose in the odometry frame, velocity in the body frame."""

    pose: Pose2D
    velocity: Velocity


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """/scan: ranges (N,) float32 in m (inf or out of limits: nothing seen), a view of the message.

    Attributes:
        angle_min, angle_increment: rad, in `frame`.
        range_min, range_max: m; values outside are not measurements.
    """

    ranges: NDArray[np.float32]
    intensities: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    frame: str

    def angles(self) -> NDArray[np.float32]:
        """(N,) float32 rad, one for each range; a new array."""
        import numpy as np

        steps = np.arange(self.ranges.size, dtype=np.float32)
        angles: NDArray[np.float32] = steps * np.float32(self.angle_increment) + np.float32(self.angle_min)
        return angles

    def points(self) -> NDArray[np.float32]:
        """(M, 2) float32 x, y in m in `frame` of the valid ranges; a new array."""
        from rosproto.numeric import scan_to_points

        return scan_to_points(self).astype("float32")

    @property
    def nearest(self) -> float:
        """Shortest valid range in m, inf when nothing is seen."""
        good = (self.ranges >= self.range_min) & (self.ranges <= self.range_max)
        return float(self.ranges[good].min()) if good.any() else float("inf")


@dataclass(frozen=True, slots=True)
class Imu:
    """/imu/data_raw. Units: quaternion, rad/s, m/s², in `frame`; `orientation` is None when the sensor has
    none."""

    orientation: tuple[float, float, float, float] | None
    angular_velocity: tuple[float, float, float]
    linear_acceleration: tuple[float, float, float]
    frame: str


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A camera image: pixels (height, width) or (height, width, channels), a view of the message.

    Attributes:
        encoding: As sensor_msgs names it ("rgb8", "bgr8", "mono8", "16UC1" in mm, "32FC1" in m ...).
    """

    pixels: NDArray[np.generic]
    encoding: str
    frame: str

    def depth_metres(self) -> NDArray[np.float32]:
        """(height, width) float32 in m, NaN where nothing was measured; a new array.

        Raises:
            ValueError: This is not a depth image.
        """
        import numpy as np

        if self.encoding in ("16UC1", "mono16"):
            metres: NDArray[np.float32] = self.pixels.astype(np.float32) / np.float32(1000.0)
            metres[self.pixels == 0] = np.nan
            return metres
        if self.encoding == "32FC1":
            return self.pixels.astype(np.float32)
        raise ValueError(
            say("encoding {encoding} is not a depth image; expected 16UC1 or 32FC1", encoding=self.encoding)
        )

    def visible(self) -> NDArray[np.uint8]:
        """(height, width) grey or (height, width, 3 or 4) RGB(A), to look at it.

        Depth is scaled to its range: near is bright, not measured is black.

        Raises:
            ValueError: The encoding cannot be shown.
        """
        import numpy as np

        from rosproto.numeric import picture_order, visible_depth

        if self.encoding in ("16UC1", "mono16", "32FC1"):
            return visible_depth(self.depth_metres())
        order = picture_order(self.encoding)
        return np.ascontiguousarray(self.pixels if order is None else self.pixels[..., order], np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """A point cloud: points (N, 3) float32 x, y, z in m in `frame`; rows with NaN are left out."""

    points: NDArray[np.float32]
    frame: str
