"""One filled message of each type that the topic tests send around, and what must come back."""

from __future__ import annotations

from typing import Any

import numpy as np

from rosproto.codec import encode, message_class

TYPES = [
    "std_msgs/String",
    "geometry_msgs/Twist",
    "sensor_msgs/LaserScan",
    "sensor_msgs/Image",
    "woosh_msgs/RobotStatus",
]


def sample(type_name: str) -> Any:
    """A message with values that a wrong layout would not survive."""
    message = message_class(type_name)()
    if type_name == "std_msgs/String":
        message.data = "Grüße, 机器人 = ok\n"
    elif type_name == "geometry_msgs/Twist":
        message.linear.x, message.angular.z = 0.25, -1e-300
    elif type_name == "sensor_msgs/LaserScan":
        _stamp(message)
        message.angle_increment = 0.5
        message.ranges = np.linspace(0, 30, 1080, dtype="f4")
        message.intensities = np.arange(1080, dtype="f4")
    elif type_name == "sensor_msgs/Image":
        _stamp(message)
        message.width, message.height, message.step, message.encoding = 640, 480, 1920, "rgb8"
        message.data = (np.arange(640 * 480 * 3) % 251).astype("u1")
    else:
        for field in message._spec.fields:
            if (
                field.type.base in ("uint8", "uint16", "uint32", "int32", "float32")
                and not field.type.is_array
            ):
                setattr(message, field.name, 7)
            elif field.type.base == "string" and not field.type.is_array:
                setattr(message, field.name, f"text of {field.name}")
    return message


def _stamp(message: Any) -> None:
    message.header.frame_id = "laser"
    message.header.stamp.secs, message.header.stamp.nsecs = 1_700_000_000, 999_999_999


def wire(message: Any) -> bytes:
    """The encoded message without header.seq, which every publisher counts for itself."""
    data = encode(message)
    return data[4:] if message._has_header else data


def exchange(publisher: Any, received: Any, message: Any) -> Any:
    """Publish until an echo comes back.

    rospy counts a subscriber as connected only after it has answered it, so the first echo may reach nobody.
    """
    for _ in range(20):
        publisher.publish(message)
        try:
            return received.next(1.0)
        except TimeoutError:
            continue
    raise AssertionError(f"no echo: {received.errors}, {publisher.stats()}")
