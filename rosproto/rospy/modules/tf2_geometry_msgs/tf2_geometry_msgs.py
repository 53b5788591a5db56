"""tf2_geometry_msgs: transforms stamped geometry messages with KDL."""

from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped, WrenchStamped
from PyKDL import Frame, Rotation, Vector
from tf2_ros import ConvertRegistration, TransformRegistration


def _frame(rotation, translation):
    return Frame(
        Rotation.Quaternion(rotation.x, rotation.y, rotation.z, rotation.w),
        Vector(translation.x, translation.y, translation.z),
    )


def to_msg_msg(msg):
    """Return the message unchanged."""
    return msg


from_msg_msg = to_msg_msg


def transform_to_kdl(t):
    """Convert a TransformStamped to a KDL Frame."""
    return _frame(t.transform.rotation, t.transform.translation)


def do_transform_point(point, transform):
    """Transform a PointStamped."""
    result = PointStamped()
    p = point.point
    moved = transform_to_kdl(transform) * Vector(p.x, p.y, p.z)
    result.point.x, result.point.y, result.point.z = moved
    result.header = transform.header
    return result


def do_transform_vector3(vector3, transform):
    """Transform a Vector3Stamped."""
    result = Vector3Stamped()
    v = vector3.vector
    turned = Frame(transform_to_kdl(transform).M) * Vector(v.x, v.y, v.z)
    result.vector.x, result.vector.y, result.vector.z = turned
    result.header = transform.header
    return result


def do_transform_pose(pose, transform):
    """Transform a PoseStamped."""
    result = PoseStamped()
    moved = transform_to_kdl(transform) * _frame(pose.pose.orientation, pose.pose.position)
    p, q = result.pose.position, result.pose.orientation
    p.x, p.y, p.z = moved.p
    q.x, q.y, q.z, q.w = moved.M.GetQuaternion()
    result.header = transform.header
    return result


def do_transform_wrench(wrench, transform):
    """Transform a WrenchStamped."""
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
