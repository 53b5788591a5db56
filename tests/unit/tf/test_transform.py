"""Transform values and quaternions: composition, inverse, matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto import quaternion
from rosproto.tf import Transform
from rosproto.time import Time

unit = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: sum(x * x for x in q) > 0.1)
    .map(quaternion.normalized)
)
vector = st.tuples(*[st.floats(-100, 100)] * 3)


@given(unit, vector, unit, vector)
def test_composition_is_the_matrix_product(q1, p1, q2, p2):
    a, b = Transform("map", "odom", p1, q1), Transform("odom", "base", p2, q2)
    assert (a @ b).matrix == pytest.approx(a.matrix @ b.matrix, abs=1e-7)
    assert ((a @ b).target, (a @ b).source) == ("map", "base")


@given(unit, vector)
def test_the_inverse_undoes(q, p):
    there = Transform("map", "base", p, q)
    assert (there @ there.inverse).matrix == pytest.approx(np.eye(4), abs=1e-9)


def test_frames_that_do_not_meet_are_refused():
    with pytest.raises(ValueError, match="inner frames differ"):
        Transform("map", "odom") @ Transform("base", "laser")


def test_a_planar_pose_turns_counter_clockwise():
    pose = Transform.planar("map", "base", 1.0, 2.0, math.pi / 2)
    assert pose.point((1.0, 0.0, 0.0)) == pytest.approx((1.0, 3.0, 0.0))
    assert pose.yaw == pytest.approx(math.pi / 2)


def test_many_points_move_as_one_does():
    pose = Transform.planar("map", "base", 1.0, 2.0, 0.3)
    points = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert pose.points(points)[1] == pytest.approx(pose.point((4.0, 5.0, 6.0)))
    assert pose.points(points).shape == (2, 3)


def test_a_matrix_that_is_no_rigid_transform_is_refused():
    with pytest.raises(ValueError, match="not a rotation"):
        Transform.from_matrix("a", "b", np.diag([1.0, 1.0, -1.0, 1.0]))
    with pytest.raises(ValueError, match="shape"):
        Transform.from_matrix("a", "b", np.eye(3))


def test_a_matrix_makes_the_transform_it_came_from():
    pose = Transform.planar("map", "base", 1.0, 2.0, 3.0)
    assert Transform.from_matrix("map", "base", pose.matrix).matrix == pytest.approx(pose.matrix)


def test_a_stamp_is_kept_to_the_nanosecond():
    stamp = Time(1_700_000_000, 123_456_789)
    assert Transform.planar("a", "b", 0, 0, 0, stamp=stamp).stamp == stamp
