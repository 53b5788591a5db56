"""Makes the messages that the verbs send. Classes are looked up lazily, by name."""

from __future__ import annotations

import math
from typing import Any

import rosproto
from rosproto.codec import DynamicMessage, ServiceType
from rosproto.coercion import as_float
from rosproto.sentence import say
from woosh_pure.geometry import Footprint, Pose2D, Velocity, quaternion_from_yaw, yaw_from_quaternion


def message_type(name: str) -> type[DynamicMessage]:
    """The class of a message type, "package/Type"."""
    return rosproto.message_class(name)


def service_type(name: str) -> type[ServiceType]:
    """The class of a service type, "package/Type"."""
    return rosproto.service_class(name)


_MAX_FLOAT32 = 3.4e38


def _new(name: str) -> DynamicMessage:
    return message_type(name)()


def require_finite(value: Any, what: str) -> Any:
    """A message (or list) of any type, checked: every floating-point number in it is finite, and no larger
    than a float of 32 bits, as which robots often store it.

    Raises:
        ValueError: One is not; the text says where.
    """
    if not isinstance(value, (float, int, str)) and getattr(value, "shape", None) == ():
        value = value.item()  # a number of numpy
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(say("{what}: {value} is not finite; nothing was sent", what=what, value=value))
        if abs(value) > _MAX_FLOAT32:
            raise ValueError(
                say("{what}: {value} is implausibly large; nothing was sent", what=what, value=value)
            )
    elif hasattr(value, "__slots__") and hasattr(value, "_type"):
        for name in value.__slots__:
            require_finite(getattr(value, name), f"{what}.{name}")
    elif isinstance(value, (list, tuple)) or getattr(getattr(value, "dtype", None), "kind", "") == "f":
        for index, each in enumerate(value.tolist() if hasattr(value, "tolist") else value):
            require_finite(each, f"{what}[{index}]")
    return value


def set_pose(target: DynamicMessage, pose: Pose2D) -> None:
    """Fill a geometry_msgs/Pose, whose z stays."""
    target.position.x, target.position.y = pose.x, pose.y
    set_yaw(target.orientation, pose.yaw)


def set_yaw(target: DynamicMessage, yaw: float) -> None:
    """Fill a geometry_msgs/Quaternion."""
    target.x, target.y, target.z, target.w = quaternion_from_yaw(yaw)


def pose_message(pose: Pose2D) -> DynamicMessage:
    """geometry_msgs/Pose, z 0."""
    message = _new("geometry_msgs/Pose")
    set_pose(message, as_pose(pose).require_sensible())
    return message


def as_pose(value: object) -> Pose2D:
    """What a caller gave for a pose.

    Raises:
        TypeError: It is something else, such as one number.
    """
    if not isinstance(value, Pose2D):
        raise TypeError(say("{value!r} is not a pose; expected Pose2D(x, y, yaw)", value=value))
    return value


def stamped_pose(pose: Pose2D) -> DynamicMessage:
    """geometry_msgs/PoseStamped in the pose's frame, with stamp zero.

    The robot takes the newest transform for it. At a time of this computer's clock it may have none.
    """
    message = _new("geometry_msgs/PoseStamped")
    message.header.frame_id = as_pose(pose).frame.lstrip("/")  # tf2 refuses one that begins with a slash
    message.pose = pose_message(pose)
    return message


def pose_with_covariance(pose: Pose2D, *, position_deviation: float, yaw_deviation: float) -> DynamicMessage:
    """geometry_msgs/PoseWithCovarianceStamped with stamp zero; deviations (1 sigma) in m and rad."""
    position_deviation, yaw_deviation = as_float(position_deviation), as_float(yaw_deviation)
    for value in (position_deviation, yaw_deviation):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(say("deviation {value}: must be a positive number (m, rad)", value=value))
    message = _new("geometry_msgs/PoseWithCovarianceStamped")
    message.header.frame_id = pose.frame.lstrip("/")  # tf2 refuses one that begins with a slash
    message.pose.pose = pose_message(pose)
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = position_deviation**2
    covariance[35] = yaw_deviation**2
    message.pose.covariance = covariance
    return message


def twist(velocity: Velocity) -> DynamicMessage:
    """geometry_msgs/Twist."""
    message = _new("geometry_msgs/Twist")
    message.linear.x, message.linear.y, message.angular.z = velocity.vx, velocity.vy, velocity.wz
    return message


def polygon(footprint: Footprint) -> DynamicMessage:
    """geometry_msgs/Polygon."""
    message = _new("geometry_msgs/Polygon")
    point = message_type("geometry_msgs/Point32")
    message.points = [point(x=x, y=y, z=0.0) for x, y in footprint.points]
    return message


def pose_of(pose: DynamicMessage, frame: str, child: str = "base_link") -> Pose2D:
    """geometry_msgs/Pose to a `Pose2D`; height, roll and pitch are left out."""
    q = pose.orientation
    return Pose2D(
        pose.position.x, pose.position.y, yaw_from_quaternion(q.x, q.y, q.z, q.w), frame.lstrip("/"), child
    )
