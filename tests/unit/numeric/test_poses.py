"""Poses, matrices, quaternions, yaw."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosproto.codec import message_class
from rosproto.numeric import (
    matrix_to_pose,
    matrix_to_quaternion,
    matrix_to_transform,
    pose_to_matrix,
    quaternion_to_matrix,
    quaternion_to_yaw,
    yaw_to_quaternion,
)

Quaternion = message_class("geometry_msgs/Quaternion")
parts = st.floats(-1, 1).map(lambda v: round(v, 3))


def test_a_pose_takes_points_to_the_outer_frame() -> None:
    """One metre ahead of a robot at (1, 2) that looks along +y is (1, 3)."""
    pose = message_class("geometry_msgs/Pose")(orientation=yaw_to_quaternion(math.pi / 2))
    pose.position.x, pose.position.y = 1.0, 2.0
    matrix = pose_to_matrix(pose)
    assert np.allclose(matrix @ [1, 0, 0, 1], [1, 3, 0, 1])
    assert matrix.shape == (4, 4)
    transform = matrix_to_transform(matrix)
    assert np.allclose(pose_to_matrix(transform), matrix)
    assert transform.translation.y == 2.0


@given(parts, parts, parts, parts)
def test_matrices_and_quaternions_undo_each_other(x: float, y: float, z: float, w: float) -> None:
    """Up to the sign, and the length, which is brought to 1."""
    assume(math.hypot(x, y, z, w) > 0.01)
    matrix = quaternion_to_matrix(Quaternion(x, y, z, w))
    assert np.allclose(matrix @ matrix.T, np.eye(3))
    back = matrix_to_quaternion(matrix)
    assert back.w >= 0
    assert math.isclose(math.hypot(back.x, back.y, back.z, back.w), 1.0, rel_tol=1e-6)
    assert np.allclose(quaternion_to_matrix(back), matrix, atol=1e-9)
    outer = np.eye(4)
    outer[:3, :3], outer[:3, 3] = matrix, (x, y, z)
    assert np.allclose(pose_to_matrix(matrix_to_pose(outer)), outer, atol=1e-9)


@given(st.floats(-3.14, 3.14))
def test_yaw_survives(yaw: float) -> None:
    """Counter-clockwise positive, radians."""
    assert math.isclose(quaternion_to_yaw(yaw_to_quaternion(yaw)), yaw, abs_tol=1e-9)


def test_what_is_no_rotation_is_refused() -> None:
    """A new message's quaternion is all zero: a common mistake, told in words."""
    with pytest.raises(ValueError, match="a new message has w = 0"):
        quaternion_to_yaw(Quaternion())
    with pytest.raises(ValueError, match="is not a rotation"):
        quaternion_to_matrix(Quaternion(w=math.nan))
    for wrong in (np.eye(4) * 2, np.diag([1, 1, -1, 1]), np.eye(2)):
        with pytest.raises(ValueError, match="matrix"):
            matrix_to_pose(wrong)
    with pytest.raises(ValueError, match=r"a \(3, 3\) or \(4, 4\) matrix is expected, not \(2, 2\)"):
        matrix_to_quaternion(np.eye(2))
