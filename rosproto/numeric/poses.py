"""Convert poses, transforms and quaternions to matrices and angles, and back.

Source: REP 103 (right-handed, x forward).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rosproto import quaternion as rotation
from rosproto.codec import DynamicMessage, message_class
from rosproto.sentence import both, say

if TYPE_CHECKING:
    from msgdefs.geometry_msgs.msg import Pose, Quaternion, Transform


def _unit(quaternion: Quaternion | DynamicMessage) -> tuple[float, float, float, float]:
    """x, y, z, w of length 1."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not math.isfinite(length) or length < 1e-9:
        wrong = say("quaternion ({x}, {y}, {z}, {w}) is not a rotation", x=x, y=y, z=z, w=w)
        raise ValueError(both(wrong, "the identity has w = 1, a new message has w = 0"))
    return rotation.normalized((x, y, z, w))


def quaternion_to_matrix(quaternion: Quaternion | DynamicMessage) -> NDArray[np.float64]:
    """(3, 3) float64 rotation of a geometry_msgs/Quaternion, which is normalised first.

    Raises:
        ValueError: All its parts are 0, or not finite.
    """
    return np.array(rotation.to_matrix(_unit(quaternion)))


def matrix_to_quaternion(matrix: ArrayLike) -> Any:
    """A geometry_msgs/Quaternion, w >= 0, of the rotation in a (3, 3) or (4, 4) matrix.

    Raises:
        ValueError: The shape is wrong, or the matrix is not a rotation.
    """
    q = rotation.from_matrix(_rotation(matrix).tolist())
    sign = -1.0 if q[3] < 0 else 1.0
    return message_class("geometry_msgs/Quaternion")(*(part * sign for part in q))


def _rotation(matrix: ArrayLike) -> NDArray[np.float64]:

    matrix = np.asarray(matrix, np.float64)
    if matrix.shape not in ((3, 3), (4, 4)):
        raise ValueError(f"a (3, 3) or (4, 4) matrix is expected, not {matrix.shape}")
    turn = matrix[:3, :3]
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-4) or np.linalg.det(turn) < 0:
        raise ValueError("the matrix is not a rotation: its columns are not orthonormal and right-handed")
    return turn


def pose_to_matrix(pose: Pose | Transform | DynamicMessage) -> NDArray[np.float64]:
    """(4, 4) float64 matrix of a geometry_msgs/Pose or geometry_msgs/Transform; metres.

    For a pose of frame B given in frame A it is A_T_B: it converts points of B, as columns (x, y, z, 1), to
    A. For a TransformStamped, A is its header.frame_id and B its child_frame_id.

    Raises:
        ValueError: The orientation is not a rotation.
    """
    where = pose.position if hasattr(pose, "position") else pose.translation
    turned = pose.orientation if hasattr(pose, "orientation") else pose.rotation
    matrix = np.eye(4)
    matrix[:3, :3] = quaternion_to_matrix(turned)
    matrix[:3, 3] = where.x, where.y, where.z
    return matrix


def matrix_to_pose(matrix: ArrayLike) -> Any:
    """The geometry_msgs/Pose of a (4, 4) matrix; the inverse of `pose_to_matrix`.

    Raises:
        ValueError: It is not a rigid transform.
    """
    point = message_class("geometry_msgs/Point")(*_translation(matrix))
    return message_class("geometry_msgs/Pose")(position=point, orientation=matrix_to_quaternion(matrix))


def matrix_to_transform(matrix: ArrayLike) -> Any:
    """The geometry_msgs/Transform of a (4, 4) matrix; the inverse of `pose_to_matrix`.

    Raises:
        ValueError: It is not a rigid transform.
    """
    vector = message_class("geometry_msgs/Vector3")(*_translation(matrix))
    return message_class("geometry_msgs/Transform")(translation=vector, rotation=matrix_to_quaternion(matrix))


def _translation(matrix: ArrayLike) -> list[float]:

    matrix = np.asarray(matrix, np.float64)
    if matrix.shape != (4, 4) or not np.allclose(matrix[3], (0, 0, 0, 1)):
        raise ValueError(f"a (4, 4) matrix with last row 0 0 0 1 is expected, not {matrix.shape}")
    return [float(part) for part in matrix[:3, 3]]


def quaternion_to_yaw(quaternion: Quaternion | DynamicMessage) -> float:
    """Rotation about z in radians, counter-clockwise positive, -pi..pi (the yaw of roll-pitch-yaw).

    Raises:
        ValueError: The quaternion is not a rotation.
    """
    return rotation.yaw_of(_unit(quaternion))


def yaw_to_quaternion(yaw: float) -> Any:
    """The geometry_msgs/Quaternion of a rotation about z by `yaw` radians."""
    return message_class("geometry_msgs/Quaternion")(*rotation.from_yaw(yaw))
