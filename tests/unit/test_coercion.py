"""Numbers of numpy and others become floats."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from rosproto.coercion import as_float, whole


@pytest.mark.parametrize(
    "given",
    [np.float16(0.5), np.float32(0.5), np.float64(0.5), np.array(0.5), Decimal("0.5"), Fraction(1, 2)],
)
def test_a_number_becomes_a_float(given):
    assert as_float(given) == 0.5
    assert type(as_float(given)) is float


def test_whole_numbers_too_and_none_stays():
    assert type(as_float(np.int8(2))) is float
    assert as_float(None) is None


@pytest.mark.parametrize("given", ["0.5", b"1", bytearray(b"1"), [1.0], object(), True, False, np.True_, 1j])
def test_what_is_no_number_is_refused(given):
    with pytest.raises(TypeError):
        as_float(given)


@pytest.mark.parametrize(
    ("given", "number"),
    [
        (10**400, math.inf),
        (-(10**400), -math.inf),
        (Fraction(10**400), math.inf),
        (Decimal("Infinity"), math.inf),
    ],
)
def test_what_is_too_large_for_a_float_is_infinite(given, number):
    assert as_float(given) == number


@pytest.mark.parametrize("given", [Decimal("sNaN"), Decimal("NaN"), np.float16("nan")])
def test_what_is_not_a_number_is_nan_and_no_error(given):
    assert math.isnan(as_float(given))


@pytest.mark.parametrize("given", [7, np.int8(7), np.uint64(7), np.array(7)])
def test_a_whole_number_becomes_an_int(given):
    assert whole(given) == 7
    assert type(whole(given)) is int


@pytest.mark.parametrize(
    "given", [7.0, np.float32(7), np.array(7.5), np.array([7]), "7", None, Decimal(7), True]
)
def test_what_is_no_whole_number_is_none(given):
    assert whole(given) is None
