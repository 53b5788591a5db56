"""tf2_sensor_msgs: transforming point clouds."""

from PyKDL import Vector
from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud, read_points
from tf2_geometry_msgs import _frame
from tf2_ros import ConvertRegistration, TransformRegistration


def to_msg_msg(msg):
    """A message is one already."""
    return msg


from_msg_msg = to_msg_msg


def do_transform_cloud(cloud, transform):
    """A PointCloud2 in the transform's frame: its first three fields are x, y, z."""
    frame = _frame(transform.transform.rotation, transform.transform.translation)
    points = []
    for point in read_points(cloud):
        moved = frame * Vector(*map(float, point[:3]))
        points.append((moved[0], moved[1], moved[2], *point[3:]))
    return create_cloud(transform.header, cloud.fields, points)


TransformRegistration().add(PointCloud2, do_transform_cloud)
ConvertRegistration().add_to_msg(PointCloud2, to_msg_msg)
ConvertRegistration().add_from_msg(PointCloud2, from_msg_msg)
