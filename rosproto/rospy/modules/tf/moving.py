"""Transforms stamped messages by (4, 4) matrices, as tf did before tf2. A separate module: needs numpy."""

import numpy
from geometry_msgs.msg import (
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    QuaternionStamped,
    Vector3,
    Vector3Stamped,
)

from . import transformations


def _stamped(cls, target_frame, header):
    result = cls()
    result.header.stamp, result.header.frame_id = header.stamp, target_frame
    return result


def _times(matrix, v):
    return numpy.dot(matrix, numpy.array([v.x, v.y, v.z, 1.0])).tolist()[:3]


def _turn(q):
    return transformations.quaternion_matrix((q.x, q.y, q.z, q.w))


def pose_matrix(translation, rotation):
    """The (4, 4) matrix of a pose."""
    return numpy.dot(
        transformations.translation_matrix(translation), transformations.quaternion_matrix(rotation)
    )


def point(matrix, target_frame, ps):
    """Transform a PointStamped."""
    result = _stamped(PointStamped, target_frame, ps.header)
    result.point = Point(*_times(matrix, ps.point))
    return result


def vector3(matrix, target_frame, v3s):
    """Transform a Vector3Stamped."""
    matrix[:3, 3] = 0.0
    result = _stamped(Vector3Stamped, target_frame, v3s.header)
    result.vector = Vector3(*_times(matrix, v3s.vector))
    return result


def quaternion(matrix, target_frame, ps):
    """Transform a QuaternionStamped."""
    turned = transformations.quaternion_from_matrix(numpy.dot(matrix, _turn(ps.quaternion)))
    result = _stamped(QuaternionStamped, target_frame, ps.header)
    result.quaternion = Quaternion(*turned.tolist())
    return result


def pose(matrix, target_frame, ps):
    """Transform a PoseStamped."""
    p = ps.pose.position
    own = numpy.dot(transformations.translation_matrix((p.x, p.y, p.z)), _turn(ps.pose.orientation))
    moved = numpy.dot(matrix, own)
    result = _stamped(PoseStamped, target_frame, ps.header)
    result.pose = Pose(
        Point(*transformations.translation_from_matrix(moved).tolist()),
        Quaternion(*transformations.quaternion_from_matrix(moved).tolist()),
    )
    return result


def point_cloud(matrix, target_frame, cloud):
    """Transform a sensor_msgs/PointCloud."""
    from sensor_msgs.msg import PointCloud

    result = _stamped(PointCloud, target_frame, cloud.header)
    result.channels = cloud.channels
    result.points = [Point(*_times(matrix, one)) for one in cloud.points]
    return result
