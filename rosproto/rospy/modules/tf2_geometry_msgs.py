"""tf2_geometry_msgs: transforming stamped geometry."""

from tf2_ros.buffer import TransformRegistration
from tf2_ros.geometry import (
    PointStamped,
    PoseStamped,
    Vector3Stamped,
    do_transform_point,
    do_transform_pose,
    do_transform_vector3,
    register,
)

register(TransformRegistration)
