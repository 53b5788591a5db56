"""Messages to values, one function per type; `to_value` finds the right one by topic or type.

Messages are anything with the right attributes: at run time this file imports no message class.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

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
from woosh_pure.faults import StatusCode, decode_status_code
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.values import state as v
from woosh_pure.values.messages import pose_of

if TYPE_CHECKING:
    from rosproto.codec import DynamicMessage


def stamp_of(message: object) -> float | None:
    """The message's own stamp in s since 1970; None when it has no header or an empty stamp."""
    header = getattr(message, "header", None)
    stamp = getattr(header, "stamp", None)
    if stamp is None or not (stamp.secs or stamp.nsecs):
        return None
    return float(stamp.secs) + float(stamp.nsecs) * 1e-9


def _robot_status(m: DynamicMessage) -> v.RobotStatus:
    return v.RobotStatus(
        m.task_id,
        TaskType(m.task_type),
        TaskState(m.task_state),
        ActionType(m.action_type),
        ActionState(m.action_state),
        RobotState(m.robot_state),
        RobotMode(m.robot_mode),
        WorkMode(m.work_mode),
        m.wait_id,
        m.dest,
        m.msg,
        m.time,
    )


def _battery(m: DynamicMessage) -> v.Battery:
    return v.Battery(
        percent=m.batteryPercentage,
        charge_mode=ChargeMode(m.chargeMode),
        charge_status=ChargeStatus(m.chargeStatus),
        voltage=m.batteryVoltage,
        current=m.batteryCurrent,
        time_remaining=m.timeRemain,
        temperature_max=m.tempMax,
        temperature_min=m.tempMin,
        capacity_remaining=m.capacityRemain,
        capacity_full=m.capacityFull,
        capacity_design=m.capacityDesign,
        charge_cycles=m.chargeCycle,
        battery_cycles=m.batteryCycle,
        cell_voltage_max=m.cellVoltageMax,
        cell_voltage_min=m.cellVoltageMin,
        bms_status=m.bmsStatus,
        submodule=m.submodule,
    )


def _bms(m: DynamicMessage) -> v.Bms:
    return v.Bms(
        m.BMSStatus,
        m.current,
        m.voltageMax,
        m.voltageMin,
        m.voltageTotal,
        m.temperatureMax,
        m.temperatureMin,
        m.chargeCycle,
        m.capacityResidue,
        m.capacityTotal,
        m.switchStatus,
    )


def _parameters(m: DynamicMessage) -> v.Parameters:
    return v.Parameters(
        wheel_perimeter=m.wheelPerimeter,
        wheel_distance=m.wheelDistant,
        ratio_left=m.ratioLeft,
        ratio_right=m.ratioRight,
        pulses_per_turn=m.pulsePerCircle,
        max_rpm=m.maxRPM,
        min_speed=m.minSpeed,
        max_speed=m.maxSpeed,
        max_linear=m.maxLinear,
        max_angular=m.maxAngular,
        joystick_max_linear=m.joystickMaxLinear,
        joystick_max_angular=m.joystickMaxAngular,
    )


def _information(m: DynamicMessage) -> v.Information:
    return v.Information(
        m.hardwareVersion, m.softwareVersion, m.IAPSoftwareVersion, m.movebaseType, _parameters(m.parameter)
    )


def _pose2d(m: DynamicMessage) -> Pose2D:
    return Pose2D(m.x, m.y, m.theta)


def _pose_estimate(m: DynamicMessage) -> v.PoseEstimate:
    import numpy as np

    covariance = np.asarray(m.pose.covariance, dtype=np.float64).reshape(6, 6)
    return v.PoseEstimate(pose_of(m.pose.pose, m.header.frame_id or "map"), covariance)


def _twist(m: DynamicMessage) -> Velocity:
    return Velocity(m.linear.x, m.linear.y, m.angular.z)


def _odometry(m: DynamicMessage) -> v.Odometry:
    pose = pose_of(m.pose.pose, m.header.frame_id or "odom", m.child_frame_id or "base_link")
    return v.Odometry(pose, _twist(m.twist.twist))


def _scan(m: DynamicMessage) -> v.LaserScan:
    import numpy as np

    return v.LaserScan(
        np.asarray(m.ranges, np.float32),
        np.asarray(m.intensities, np.float32),
        m.angle_min,
        m.angle_increment,
        m.range_min,
        m.range_max,
        m.header.frame_id,
    )


def _imu(m: DynamicMessage) -> v.Imu:
    q, w, a = m.orientation, m.angular_velocity, m.linear_acceleration
    # sensor_msgs/Imu: a first covariance of -1 says that the sensor has no orientation.
    orientation = None if m.orientation_covariance[0] == -1 else (q.x, q.y, q.z, q.w)
    return v.Imu(orientation, (w.x, w.y, w.z), (a.x, a.y, a.z), m.header.frame_id)


def _image(m: DynamicMessage) -> v.Image:
    from rosproto.numeric import image_to_array

    return v.Image(image_to_array(m), m.encoding, m.header.frame_id)


def _cloud(m: DynamicMessage) -> v.PointCloud:
    import numpy as np

    from rosproto.numeric import cloud_to_points

    return v.PointCloud(cloud_to_points(m).astype(np.float32, copy=False), m.header.frame_id)


def _status_code(m: DynamicMessage) -> StatusCode:
    return decode_status_code(m.data)


def _data(m: DynamicMessage) -> Any:
    return m.data


_BY_TYPE: dict[str, Callable[[DynamicMessage], Any]] = {
    "woosh_msgs/RobotStatus": _robot_status,
    "woosh_msgs/Battery": _battery,
    "woosh_msgs/BMS": _bms,
    "woosh_msgs/Parameter": _parameters,
    "woosh_msgs/Information": _information,
    "geometry_msgs/Pose2D": _pose2d,
    "geometry_msgs/PoseWithCovarianceStamped": _pose_estimate,
    "geometry_msgs/Twist": _twist,
    "nav_msgs/Odometry": _odometry,
    "sensor_msgs/LaserScan": _scan,
    "sensor_msgs/Imu": _imu,
    "sensor_msgs/Image": _image,
    "sensor_msgs/PointCloud2": _cloud,
    "std_msgs/UInt64": _status_code,
    "std_msgs/Float64": _data,
    "std_msgs/UInt32": _data,
    "std_msgs/String": _data,
}


def prepare(type_name: str, empty: Any) -> None:
    """Convert an empty message before the first real one: the conversion of some types imports numpy or reads
    a table, and later no file may be left to read it from.
    """
    try:
        to_value(type_name, empty)
    except ValueError:
        pass  # an empty picture; everything is imported by then


def to_value(type_name: str, message: Any) -> Any:
    """The value of a message; a type without a value class stays the message itself.

    Raises:
        ValueError: The message contradicts itself (an image shorter than it says).
    """
    convert = _BY_TYPE.get(type_name)
    return message if convert is None else convert(message)
