"""Sensor and geometry messages as numpy arrays, and back.

Each function documents shape, dtype and frame of its result, and whether it is a view of the message or a
copy. Views of a received message are read-only; `.copy()` gives a writable array. Messages with numpy values
and messages with genpy's values are accepted.
"""

from __future__ import annotations

from rosproto.numeric.clouds import cloud_to_array, cloud_to_points, points_to_cloud, scan_to_points
from rosproto.numeric.grids import array_to_grid, grid_to_array
from rosproto.numeric.images import (
    array_to_image,
    compressed_image_bytes,
    depth_millimetres,
    image_to_array,
    picture_order,
    visible_depth,
)
from rosproto.numeric.pngfile import decode_png, encode_png, is_png
from rosproto.numeric.poses import (
    matrix_to_pose,
    matrix_to_quaternion,
    matrix_to_transform,
    pose_to_matrix,
    quaternion_to_matrix,
    quaternion_to_yaw,
    yaw_to_quaternion,
)

__all__ = [
    "array_to_grid",
    "array_to_image",
    "cloud_to_array",
    "cloud_to_points",
    "compressed_image_bytes",
    "decode_png",
    "depth_millimetres",
    "encode_png",
    "grid_to_array",
    "image_to_array",
    "is_png",
    "matrix_to_pose",
    "matrix_to_quaternion",
    "matrix_to_transform",
    "picture_order",
    "points_to_cloud",
    "pose_to_matrix",
    "quaternion_to_matrix",
    "quaternion_to_yaw",
    "scan_to_points",
    "visible_depth",
    "yaw_to_quaternion",
]
