"""tf_conversions.posemath: converts PyKDL frames from and to poses, lookups and matrices."""

import numpy
import PyKDL
from geometry_msgs.msg import Point, Pose, Quaternion
from PyKDL import *  # as programs expect
from PyKDL import Frame, Rotation, Vector


def fromTf(tf):
    """Frame from the result of `lookupTransform`: (position, quaternion)."""
    position, turn = tf
    return Frame(Rotation.Quaternion(*turn), Vector(*position))


def toTf(f):
    """Convert a frame to (position, quaternion)."""
    return (f.p[0], f.p[1], f.p[2]), f.M.GetQuaternion()


def fromMsg(p):
    """Frame from a Pose."""
    position, turn = p.position, p.orientation
    return Frame(
        Rotation.Quaternion(turn.x, turn.y, turn.z, turn.w), Vector(position.x, position.y, position.z)
    )


def toMsg(f):
    """Convert a frame to a Pose."""
    return Pose(Point(f.p[0], f.p[1], f.p[2]), Quaternion(*f.M.GetQuaternion()))


def fromMatrix(m):
    """Frame from a (4, 4) matrix."""
    return Frame(
        Rotation(*[m[row, i] for row in range(3) for i in range(3)]), Vector(*[m[i, 3] for i in range(3)])
    )


def toMatrix(f):
    """Convert a frame to a (4, 4) matrix."""
    return numpy.array([[f[row, i] for i in range(4)] for row in range(3)] + [[0, 0, 0, 1]], dtype=float)
