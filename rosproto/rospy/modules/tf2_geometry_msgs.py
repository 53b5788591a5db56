"""tf2_geometry_msgs: transforming stamped geometry, each sum in KDL's order."""

import math

from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped, WrenchStamped
from tf2_ros import ConvertRegistration, TransformRegistration


def _rows(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    return (
        (ww + xx - yy - zz, 2 * x * y - 2 * w * z, 2 * x * z + 2 * w * y),
        (2 * x * y + 2 * w * z, ww - xx + yy - zz, 2 * y * z - 2 * w * x),
        (2 * x * z - 2 * w * y, 2 * y * z + 2 * w * x, ww - xx - yy + zz),
    )


def _quaternion(m):
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 1e-12:
        s = 0.5 / math.sqrt(trace + 1.0)
        return (m[2][1] - m[1][2]) * s, (m[0][2] - m[2][0]) * s, (m[1][0] - m[0][1]) * s, 0.25 / s
    first = m[0][0] > m[1][1] and m[0][0] > m[2][2]
    i = 0 if first else 1 + (m[1][1] <= m[2][2])
    j, k = (i + 1) % 3, (i + 2) % 3
    low, high = min(j, k), max(j, k)
    s = 2.0 * math.sqrt(1.0 + m[i][i] - m[low][low] - m[high][high])
    q = [0.0, 0.0, 0.0, (m[k][j] - m[j][k]) / s]
    q[i] = 0.25 * s
    q[j] = (m[i][j] + m[j][i]) / s
    q[k] = (m[i][k] + m[k][i]) / s
    return tuple(q)


def _times(rows, v):
    return tuple(row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in rows)


def _moved(rows, translation, v):
    turned = _times(rows, (v.x, v.y, v.z))
    return turned[0] + translation.x, turned[1] + translation.y, turned[2] + translation.z


def to_msg_msg(msg):
    """A message is one already."""
    return msg


from_msg_msg = to_msg_msg


def do_transform_point(point, transform):
    """A PointStamped in the transform's frame."""
    result = PointStamped()
    rows, translation = _rows(transform.transform.rotation), transform.transform.translation
    result.point.x, result.point.y, result.point.z = _moved(rows, translation, point.point)
    result.header = transform.header
    return result


def do_transform_vector3(vector3, transform):
    """A Vector3Stamped in the transform's frame."""
    result = Vector3Stamped()
    v = vector3.vector
    x, y, z = _times(_rows(transform.transform.rotation), (v.x, v.y, v.z))
    result.vector.x, result.vector.y, result.vector.z = x + 0, y + 0, z + 0
    result.header = transform.header
    return result


def do_transform_pose(pose, transform):
    """A PoseStamped in the transform's frame."""
    result = PoseStamped()
    rows, translation = _rows(transform.transform.rotation), transform.transform.translation
    p, q = result.pose.position, result.pose.orientation
    p.x, p.y, p.z = _moved(rows, translation, pose.pose.position)
    columns = zip(*_rows(pose.pose.orientation))
    turned = [_times(rows, column) for column in columns]
    q.x, q.y, q.z, q.w = _quaternion(list(zip(*turned)))
    result.header = transform.header
    return result


def do_transform_wrench(wrench, transform):
    """A WrenchStamped in the transform's frame."""
    result = WrenchStamped()
    for part in ("force", "torque"):
        vector = Vector3Stamped(vector=getattr(wrench.wrench, part))
        setattr(result.wrench, part, do_transform_vector3(vector, transform).vector)
    result.header = transform.header
    return result


for _type, _function in (
    (PointStamped, do_transform_point),
    (Vector3Stamped, do_transform_vector3),
    (PoseStamped, do_transform_pose),
    (WrenchStamped, do_transform_wrench),
):
    TransformRegistration().add(_type, _function)
    ConvertRegistration().add_to_msg(_type, to_msg_msg)
    ConvertRegistration().add_from_msg(_type, from_msg_msg)
