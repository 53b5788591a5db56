"""The maxSpeed of an edge: overshoot passes, a drive that stays above it is reported."""

from __future__ import annotations

import pytest

from tests.support.fleet import order_json
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.monitor import EdgeSpeedMonitor, speed_above_limit
from woosh_pure.fleet.order.events import Drive


def drive(limit: float | None = 0.5) -> Drive:
    data = order_json(nodes="ab")
    if limit is not None:
        data["edges"][0]["maxSpeed"] = limit
    order = read_order(data)
    return Drive(1, order.nodes[1], order.edges[0])


@pytest.mark.parametrize(
    ("limit", "velocity", "expected"),
    [
        (0.5, (0.55, 0.0, 0.0), 0.0),  # overshoot of a controller
        (0.5, (-0.7, 0.0, 0.0), 0.7),
        (0.5, (0.3, 0.6, 0.0), 0.67),
        (0.5, (0.0, 0.0, 3.0), 0.0),
        (0.5, None, 0.0),
        (None, (2.0, 0.0, 0.0), 0.0),
    ],
)
def test_only_a_speed_well_above_the_limit_counts(
    limit: float | None, velocity: tuple[float, float, float] | None, expected: float
) -> None:
    assert speed_above_limit(drive(limit), velocity) == pytest.approx(expected, abs=0.01)
    assert speed_above_limit(None, velocity) == 0.0


def test_a_robot_has_time_to_slow_down_at_the_start_of_a_drive() -> None:
    """2 s from the start, then 0.3 s above the limit."""
    monitor, fast = EdgeSpeedMonitor(), (0.8, 0.0, 0.0)
    monitor.drive_began(100.0)
    assert [monitor.check(drive(), fast, now) for now in (100.1, 102.0, 102.2)] == [None] * 3
    assert monitor.must_check(drive(), (0.0, 0.0, 0.0))
    assert monitor.check(drive(), fast, 102.4) == (
        "it drove at 0.80 m/s, and edge ab allows 0.5 m/s; it is halted"
    )


def test_a_robot_that_slows_down_in_time_is_not_reported() -> None:
    monitor, fast, slow = EdgeSpeedMonitor(), (0.8, 0.0, 0.0), (0.4, 0.0, 0.0)
    monitor.drive_began(100.0)
    found = [
        monitor.check(drive(), velocity, now)
        for velocity, now in ((fast, 110.0), (fast, 110.2), (slow, 110.25), (fast, 110.4), (fast, 110.6))
    ]
    assert found == [None] * 5
    assert monitor.check(drive(), slow, 110.7) is None
    assert not monitor.must_check(drive(), slow)
    assert monitor.must_check(drive(), fast)
