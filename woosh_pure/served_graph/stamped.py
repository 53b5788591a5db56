"""Fill headers and transforms of messages."""

from __future__ import annotations

from rosproto.codec import DynamicMessage
from woosh_pure.geometry import Pose2D
from woosh_pure.values.messages import message_type, set_yaw


def stamp(message: DynamicMessage, frame: str, now: float) -> None:
    """Fill a message's header."""
    header = message.header
    header.frame_id = frame
    header.stamp.secs = int(now)
    header.stamp.nsecs = int((now % 1.0) * 1e9)


def fill_transforms(m: DynamicMessage, now: float, *links: tuple[str, str, Pose2D]) -> None:
    """tf2_msgs/TFMessage of (parent, child, pose) links."""
    transform = message_type("geometry_msgs/TransformStamped")
    m.transforms = []
    for parent, child, pose in links:
        one = transform()
        stamp(one, parent, now)
        one.child_frame_id = child
        one.transform.translation.x, one.transform.translation.y = pose.x, pose.y
        set_yaw(one.transform.rotation, pose.yaw)
        m.transforms.append(one)
