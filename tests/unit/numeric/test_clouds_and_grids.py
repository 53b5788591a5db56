"""Point clouds, scans and grids."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rosproto.codec import decode, encode, message_class
from rosproto.numeric import (
    array_to_grid,
    cloud_to_array,
    cloud_to_points,
    grid_to_array,
    points_to_cloud,
    scan_to_points,
)

Cloud = message_class("sensor_msgs/PointCloud2")
PointField = message_class("sensor_msgs/PointField")


def test_points_survive_the_wire() -> None:
    """(N, 3) float32; invalid points are dropped unless asked for."""
    points = np.array([[1, 2, 3], [np.nan, 0, 0], [4, 5, 6]], "f4")
    cloud = decode(Cloud, encode(points_to_cloud(points)))
    assert not cloud.is_dense
    assert cloud_to_points(cloud).dtype == np.float32
    assert cloud_to_points(cloud).tolist() == [[1, 2, 3], [4, 5, 6]]
    assert np.array_equal(cloud_to_points(cloud, keep_invalid=True), points, equal_nan=True)
    assert np.shares_memory(cloud_to_array(cloud), cloud.data)


def test_a_structured_array_has_the_clouds_own_fields() -> None:
    """Any order, gaps, several elements, padded rows, big-endian; ordered clouds are (H, W)."""
    fields = [
        PointField("z", 8, 7, 1),
        PointField("x", 0, 7, 1),
        PointField("y", 4, 7, 1),
        PointField("ring", 14, 4, 1),
        PointField("rgb", 16, 2, 3),
    ]
    dtype = np.dtype(
        {
            "names": ["x", "y", "z", "ring", "rgb"],
            "formats": [">f4", ">f4", ">f4", ">u2", ("u1", 3)],
            "offsets": [0, 4, 8, 14, 16],
            "itemsize": 20,
        }
    )
    rows = np.zeros((2, 3), dtype)
    rows["x"], rows["ring"], rows["rgb"] = [[1, 2, 3], [4, 5, 6]], 7, [1, 2, 3]
    data = b"".join(row.tobytes() + b"pad!" for row in rows)
    cloud = Cloud(height=2, width=3, fields=fields, is_bigendian=True, point_step=20, row_step=64, data=data)
    array = cloud_to_array(cloud)
    assert array.shape == (2, 3)
    assert array["x"].tolist() == [[1, 2, 3], [4, 5, 6]]
    assert array["ring"][1, 2] == 7
    assert array["rgb"][0, 0].tolist() == [1, 2, 3]
    assert cloud_to_points(cloud).shape == (6, 3)


def test_contradicting_clouds_are_refused() -> None:
    """What a broken driver may send is a ValueError, not a crash."""
    cloud = points_to_cloud(np.zeros((4, 3)))
    cloud.width = 5
    with pytest.raises(ValueError, match="48 bytes are there"):
        cloud_to_array(cloud)
    cloud = points_to_cloud(np.zeros((4, 3)))
    cloud.fields[0].datatype = 99
    with pytest.raises(ValueError, match="datatype 99"):
        cloud_to_array(cloud)
    cloud.fields[0].datatype = 8
    cloud.fields[2].offset = 10
    with pytest.raises(ValueError, match="do not fit point_step 12"):
        cloud_to_array(cloud)
    with pytest.raises(ValueError, match="no z"):
        cloud_to_points(
            Cloud(
                height=1,
                width=1,
                fields=[PointField("x", 0, 7, 1), PointField("y", 4, 7, 1)],
                point_step=8,
                row_step=8,
                data=bytes(8),
            )
        )
    with pytest.raises(ValueError, match=r"\(N, 3\)"):
        points_to_cloud(np.zeros((4, 2)))
    assert cloud_to_array(Cloud()).shape == (0,)


def test_scan_points() -> None:
    """x forward, y left, in metres; rays without a hit are dropped, or NaN."""
    scan = message_class("sensor_msgs/LaserScan")(
        angle_min=-math.pi / 2,
        angle_increment=math.pi / 2,
        range_min=0.1,
        range_max=10.0,
        ranges=[1.0, 2.0, 3.0, math.inf, math.nan, 0.01, 99.0],
    )
    assert np.allclose(scan_to_points(scan), [[0, -1], [2, 0], [0, 3]], atol=1e-6)
    kept = scan_to_points(scan, keep_invalid=True)
    assert kept.shape == (7, 2)
    assert np.isnan(kept[3:]).all()


def test_grids() -> None:
    """(H, W) int8, a view, row 0 lowest; both value styles."""
    cells = np.array([[0, 100, -1], [50, 0, 0]])
    grid = array_to_grid(cells, 0.05)
    data = encode(grid)
    received = decode(type(grid), data)
    assert np.array_equal(grid_to_array(received), cells)
    assert grid_to_array(received).dtype == np.int8
    assert np.shares_memory(grid_to_array(received), received.data)
    rospy = decode(message_class("nav_msgs/OccupancyGrid", value_style="rospy"), data)
    assert np.array_equal(grid_to_array(rospy), cells)
    assert (received.info.width, received.info.height, received.info.origin.orientation.w) == (3, 2, 1.0)
    received.info.width = 4
    with pytest.raises(ValueError, match="a grid of 4x2 has 8 cells, but data has 6"):
        grid_to_array(received)
    with pytest.raises(ValueError, match=r"-1\.\.100"):
        array_to_grid(np.array([[101]]), 0.05)


def test_the_origin_of_a_grid_is_the_one_given() -> None:
    """As it is; without one it lies at 0 and is not turned."""
    pose = message_class("geometry_msgs/Pose")()
    pose.position.x = -5.0
    grid = array_to_grid(np.zeros((2, 3)), 0.1, origin=pose)
    assert grid.info.origin is pose
    assert array_to_grid(np.zeros((2, 3)), 0.1).info.origin.orientation.w == 1.0
