"""A vehicle without wheels for each test."""

from __future__ import annotations

import pytest

from tests.support.fleet import PureVehicle


@pytest.fixture
def vehicle() -> PureVehicle:
    return PureVehicle()
