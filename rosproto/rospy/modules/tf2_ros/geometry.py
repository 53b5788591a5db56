"""Transforming stamped geometry: what tf2_geometry_msgs registers."""

from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped

from rosproto.tf import quaternion


def register(registration):
    """Register the three types."""
    registration.add(PointStamped, do_transform_point)
    registration.add(Vector3Stamped, do_transform_vector3)
    registration.add(PoseStamped, do_transform_pose)


def _parts(transform):
    t, r = transform.transform.translation, transform.transform.rotation
    return (t.x, t.y, t.z), (r.x, r.y, r.z, r.w)


def _moved(point, transform):
    (dx, dy, dz), rotation = _parts(transform)
    x, y, z = quaternion.rotate(rotation, (point.x, point.y, point.z))
    return x + dx, y + dy, z + dz


def do_transform_point(point, transform):
    """A PointStamped in the transform's frame."""
    result = PointStamped(header=transform.header)
    result.point.x, result.point.y, result.point.z = _moved(point.point, transform)
    return result


def do_transform_vector3(vector3, transform):
    """A Vector3Stamped in the transform's frame."""
    result = Vector3Stamped(header=transform.header)
    v = vector3.vector
    result.vector.x, result.vector.y, result.vector.z = quaternion.rotate(
        _parts(transform)[1], (v.x, v.y, v.z)
    )
    return result


def do_transform_pose(pose, transform):
    """A PoseStamped in the transform's frame."""
    result = PoseStamped(header=transform.header)
    p, o = result.pose.position, result.pose.orientation
    p.x, p.y, p.z = _moved(pose.pose.position, transform)
    q = pose.pose.orientation
    o.x, o.y, o.z, o.w = quaternion.multiply(_parts(transform)[1], (q.x, q.y, q.z, q.w))
    return result
