"""Fixtures for applications that drive a chassis: `chassis` and `simulated_chassis`.

Switch them on in a `conftest.py` with `pytest_plugins = ["woosh_pure.pytest_plugin"]`. Then:

    def test_my_program(chassis):
        my_program.deliver(chassis, "A1")

Each test has a robot of its own. Ini options: `woosh_sim_speed` (default 8).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from woosh_pure import Chassis, SimulatedChassis

__all__ = ["chassis", "pytest_addoption", "simulated_chassis"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options of this plugin."""
    parser.addini("woosh_sim_speed", "simulated seconds per second of the simulated chassis", default="8")


@pytest.fixture
def simulated_chassis(request: pytest.FixtureRequest) -> Iterator[SimulatedChassis]:
    """A simulated chassis on a master of its own."""
    from woosh_pure import SimulatedChassis

    with SimulatedChassis(speed=float(request.config.getini("woosh_sim_speed")), full_graph=False) as sim:
        yield sim


@pytest.fixture
def chassis(simulated_chassis: SimulatedChassis) -> Iterator[Chassis]:
    """A `Chassis` connected to the simulated one."""
    from woosh_pure import Chassis

    with Chassis(simulated_chassis.master_uri) as connected:
        yield connected
