"""tf2_sensor_msgs: transforms point clouds."""

from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud, read_points
from tf2_geometry_msgs import from_msg_msg, to_msg_msg, transform_to_kdl
from tf2_ros import ConvertRegistration, TransformRegistration


def do_transform_cloud(cloud, transform):
    """Transform a PointCloud2 whose first three fields are x, y, z."""
    frame = transform_to_kdl(transform)
    rows = [[frame[row, column] for column in range(4)] for row in range(3)]
    points = []
    for point in read_points(cloud):
        x, y, z = point[:3]
        points.append((*[a * x + b * y + c * z + t for a, b, c, t in rows], *point[3:]))
    return create_cloud(transform.header, cloud.fields, points)


TransformRegistration().add(PointCloud2, do_transform_cloud)
ConvertRegistration().add_to_msg(PointCloud2, to_msg_msg)
ConvertRegistration().add_from_msg(PointCloud2, from_msg_msg)
