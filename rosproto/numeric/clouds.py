"""sensor_msgs/PointCloud2 and sensor_msgs/LaserScan as points, and points as a cloud."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rosproto.codec import DynamicMessage, Message, message_class
from rosproto.numeric.images import octets

if TYPE_CHECKING:
    from msgdefs.sensor_msgs.msg import PointCloud2

DATATYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""sensor_msgs/PointField's constants."""


def cloud_to_array(cloud: PointCloud2 | DynamicMessage) -> NDArray[Any]:
    """All fields of a sensor_msgs/PointCloud2.

    Returns:
        A structured array with the cloud's field names: (N,) for an unordered cloud, (H, W) for an ordered
        one; a field of several elements is a sub-array. Units and frame are the cloud's
        (`cloud.header.frame_id`). A view of `cloud.data`.

    Raises:
        ValueError: Fields, steps and data are inconsistent.
    """
    order = ">" if cloud.is_bigendian else "<"
    names, formats, offsets = [], [], []
    for index, field in enumerate(cloud.fields):
        if field.datatype not in DATATYPES:
            raise ValueError(f"point field {field.name!r} has datatype {field.datatype}, expected 1 to 8")
        kind = order + DATATYPES[field.datatype]
        names.append(field.name or f"field_{index}")
        formats.append((kind, (field.count,)) if field.count > 1 else kind)
        offsets.append(field.offset)
    try:
        dtype = np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": cloud.point_step}
        )
    except (ValueError, TypeError) as error:
        raise ValueError(f"point fields {names} do not fit point_step {cloud.point_step}: {error}") from None
    data = octets(cloud.data)
    height, width, row_step = cloud.height, cloud.width, cloud.row_step
    row = width * cloud.point_step
    if height and width and ((row_step < row and height > 1) or data.size < (height - 1) * row_step + row):
        raise ValueError(
            f"{height} rows of {width} points of {cloud.point_step} bytes need {height * row} bytes, "
            f"but row_step is {row_step} and {data.size} bytes are there"
        )
    if height * width == 0 or cloud.point_step == 0:
        return np.empty((0,), dtype)
    points: NDArray[np.void] = np.ndarray(
        (height, width), dtype, data, strides=(row_step or row, cloud.point_step)
    )
    return points[0] if height == 1 else points


def cloud_to_points(cloud: PointCloud2 | DynamicMessage, *, keep_invalid: bool = False) -> NDArray[Any]:
    """The positions of a sensor_msgs/PointCloud2.

    Args:
        cloud: The message, with fields x, y, z.
        keep_invalid: Keep points with NaN or infinite parts, so that rows match `cloud_to_array`.

    Returns:
        (N, 3) float32 (float64 if the cloud's are), metres in `cloud.header.frame_id`. A copy.

    Raises:
        ValueError: There is no x, y or z, or the cloud is inconsistent.
    """
    points = cloud_to_array(cloud).reshape(-1)
    missing = {"x", "y", "z"}.difference(points.dtype.names or ())
    if missing:
        raise ValueError(f"the cloud has fields {points.dtype.names}, no {', '.join(sorted(missing))}")
    kind = np.result_type(np.float32, points["x"].dtype.newbyteorder("="))
    positions = np.stack([points[axis].astype(kind) for axis in "xyz"], axis=-1)
    return positions if keep_invalid else positions[np.isfinite(positions).all(axis=1)]


def points_to_cloud(points: ArrayLike, *, header: Message | None = None) -> Any:
    """A sensor_msgs/PointCloud2 of positions.

    Args:
        points: (N, 3), metres, in the frame of `header`.
        header: A std_msgs/Header to use; a new one by default.

    Returns:
        An unordered cloud with float32 fields x, y, z.

    Raises:
        ValueError: The shape is wrong.
    """
    positions = np.ascontiguousarray(points, "<f4")
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise ValueError(f"points must be (N, 3), not {positions.shape}")
    field = message_class("sensor_msgs/PointField")
    fields = [field(axis, 4 * index, 7, 1) for index, axis in enumerate("xyz")]
    return message_class("sensor_msgs/PointCloud2")(
        header=header,
        height=1,
        width=len(positions),
        fields=fields,
        point_step=12,
        row_step=12 * len(positions),
        data=positions.reshape(-1).view(np.uint8),
        is_dense=bool(np.isfinite(positions).all()),
    )


def scan_to_points(scan: Any, *, keep_invalid: bool = False) -> NDArray[np.float64]:
    """The points of a sensor_msgs/LaserScan.

    Args:
        scan: The message.
        keep_invalid: Keep rays without a hit (NaN, infinite, or outside range_min..range_max) as NaN rows, so
            that row i is ray i.

    Returns:
        (N, 2) float64: x forward and y left, metres, in the scanner's frame `scan.header.frame_id`. A copy.
    """
    ranges = np.asarray(scan.ranges, np.float64)
    angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size)
    valid = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    ranges = np.where(valid, ranges, np.nan)
    points = np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=-1)
    return points if keep_invalid else points[valid]
