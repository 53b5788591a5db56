"""sensor_msgs.point_cloud2: points of a PointCloud2 as tuples, and back."""

import math
import struct
import sys
from collections import namedtuple

from sensor_msgs.msg import PointCloud2, PointField

_DATATYPES = {
    PointField.INT8: ("b", 1),
    PointField.UINT8: ("B", 1),
    PointField.INT16: ("h", 2),
    PointField.UINT16: ("H", 2),
    PointField.INT32: ("i", 4),
    PointField.UINT32: ("I", 4),
    PointField.FLOAT32: ("f", 4),
    PointField.FLOAT64: ("d", 8),
}


def read_points(cloud, field_names=None, skip_nans=False, uvs=[]):  # noqa: B006  sensor_msgs' signature
    """The points, a tuple of values each.

    Args:
        cloud: A PointCloud2.
        field_names: Only these fields, in the cloud's order; None for all.
        skip_nans: Leave out points that have a NaN.
        uvs: Only the points at these (column, row).
    """
    # Not isinstance: what comes from a bag is of another class.
    assert getattr(cloud, "_type", "") == PointCloud2._type, "cloud is not a sensor_msgs.msg.PointCloud2"
    unpack = struct.Struct(_get_struct_fmt(cloud.is_bigendian, cloud.fields, field_names)).unpack_from
    data = cloud.data
    rows, columns = range(cloud.height), range(cloud.width)
    for column, row in uvs or ((column, row) for row in rows for column in columns):
        offset = row * cloud.row_step + column * cloud.point_step
        point = unpack(data, offset)
        if not skip_nans or not any(math.isnan(value) for value in point):
            yield point


def read_points_list(cloud, field_names=None, skip_nans=False, uvs=[]):  # noqa: B006
    """The same as a list of named tuples."""
    assert getattr(cloud, "_type", "") == PointCloud2._type, "cloud is not a sensor_msgs.msg.PointCloud2"
    names = [field.name for field in cloud.fields] if field_names is None else field_names
    Point = namedtuple("Point", names)
    return [Point._make(point) for point in read_points(cloud, names, skip_nans, uvs)]


def create_cloud(header, fields, points):
    """A PointCloud2 of one row from a list of tuples."""
    layout = struct.Struct(_get_struct_fmt(False, fields))
    data = bytearray(layout.size * len(points))
    for i, point in enumerate(points):
        layout.pack_into(data, layout.size * i, *point)
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        is_dense=False,
        is_bigendian=False,
        fields=fields,
        point_step=layout.size,
        row_step=layout.size * len(points),
        data=bytes(data),
    )


def create_cloud_xyz32(header, points):
    """A PointCloud2 from a list of (x, y, z), m."""
    names = enumerate(("x", "y", "z"))
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in names]
    return create_cloud(header, fields, points)


def _get_struct_fmt(is_bigendian, fields, field_names=None):  # programs use it by this name
    text, end = ">" if is_bigendian else "<", 0
    for field in sorted(fields, key=lambda field: field.offset):
        if field_names is not None and field.name not in field_names:
            continue
        if end < field.offset:
            text += "x" * (field.offset - end)
            end = field.offset
        if field.datatype not in _DATATYPES:
            print("Skipping unknown PointField datatype [%d]" % field.datatype, file=sys.stderr)
            continue
        letter, length = _DATATYPES[field.datatype]
        text += field.count * letter
        end += field.count * length
    return text
