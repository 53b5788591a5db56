"""Quaternions: products, matrices, interpolation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto import quaternion

unit = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: sum(x * x for x in q) > 0.1)
    .map(quaternion.normalized)
)
vector = st.tuples(*[st.floats(-100, 100)] * 3)


def same_rotation(a: quaternion.Quaternion, b: quaternion.Quaternion) -> bool:
    return abs(sum(x * y for x, y in zip(a, b, strict=True))) == pytest.approx(1.0, abs=1e-9)


@given(unit, vector)
def test_rotating_is_the_rotation_matrix(q, v):
    assert quaternion.rotate(q, v) == pytest.approx(np.array(quaternion.to_matrix(q)) @ v, abs=1e-9)


@given(unit)
def test_a_matrix_gives_back_its_quaternion_up_to_the_sign(q):
    assert same_rotation(quaternion.from_matrix(quaternion.to_matrix(q)), q)


@given(unit, unit, vector)
def test_a_product_rotates_by_the_right_factor_first(a, b, v):
    assert quaternion.rotate(quaternion.multiply(a, b), v) == pytest.approx(
        quaternion.rotate(a, quaternion.rotate(b, v)), abs=1e-9
    )


@given(unit, unit)
def test_slerp_begins_and_ends_at_its_ends_and_stays_of_length_one(a, b):
    assert same_rotation(quaternion.slerp(a, b, 0.0), a)
    assert same_rotation(quaternion.slerp(a, b, 1.0), b)
    assert sum(x * x for x in quaternion.slerp(a, b, 0.3)) == pytest.approx(1.0, abs=1e-6)


def test_all_zeros_turn_nothing():
    assert quaternion.to_matrix((0.0, 0.0, 0.0, 0.0)) == np.eye(3).tolist()


@given(st.floats(-3.1, 3.1))
def test_a_yaw_comes_back(yaw):
    assert quaternion.yaw_of(quaternion.from_yaw(yaw)) == pytest.approx(yaw)
