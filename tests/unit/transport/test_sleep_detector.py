"""Detection of a computer that slept, with clocks that the test sets."""

from __future__ import annotations

import pytest

from rosproto.transport.deadline import SleepDetector


class Clocks:
    """Awake and asleep, apart."""

    def __init__(self) -> None:
        self.awake = 100.0
        self.asleep = 5000.0

    def detector(self) -> SleepDetector:
        return SleepDetector(lambda: self.awake, lambda: self.awake + self.asleep)


@pytest.mark.parametrize("seconds", [0.0, 0.1, 1.0, 5.9])
def test_a_wait_that_takes_its_time_is_no_sleep(seconds: float) -> None:
    clocks = Clocks()
    detector = clocks.detector()
    clocks.awake += seconds
    assert detector.slept(1.0) == 0.0


def test_a_monotonic_clock_that_stood_still_tells_of_sleep_once() -> None:
    """Linux and macOS."""
    clocks = Clocks()
    detector = clocks.detector()
    clocks.awake += 0.4
    clocks.asleep += 3600
    assert detector.slept(1.0) == pytest.approx(3600)
    clocks.awake += 1.0
    assert detector.slept(1.0) == 0.0


def test_a_wait_that_takes_far_too_long_tells_of_sleep() -> None:
    """Windows, where the monotonic clock goes on."""
    clocks = Clocks()
    detector = clocks.detector()
    clocks.awake += 61.0
    assert detector.slept(1.0) == pytest.approx(60)


def test_a_clock_set_back_is_no_sleep() -> None:
    clocks = Clocks()
    detector = clocks.detector()
    clocks.awake += 1.0
    clocks.asleep -= 3600
    assert detector.slept(1.0) == 0.0


def test_the_computers_own_clocks_agree_while_it_is_awake() -> None:
    assert SleepDetector().slept(60.0) == 0.0
