"""Rates, delays and bandwidths: the figures, and the lines people's scripts parse."""

from __future__ import annotations

from rosproto.cli.rates import Bandwidth, Window, bandwidth_text, delay_text, hz_text, table


def test_a_steady_stream() -> None:
    """Ten messages a second are 10 Hz without deviation."""
    window = Window()
    for i in range(11):
        window.tick(i * 0.1)
    found = window.statistics()
    assert found is not None
    assert abs(found.mean - 0.1) < 1e-9
    assert found.count == 10
    assert hz_text(found) == "average rate: 10.000\n\tmin: 0.100s max: 0.100s std dev: 0.00000s window: 11"


def test_nothing_yet() -> None:
    """One message gives no rate, and says so."""
    window = Window()
    window.tick(1.0)
    assert window.statistics() is None
    assert hz_text(None) == "no new messages"
    assert bandwidth_text(Bandwidth(), 1.0) is None


def test_fresh_tells_whether_anything_came_since() -> None:
    """A stream that ended is told from a steady one."""
    window = Window()
    window.tick(0.0)
    window.tick(0.5)
    assert window.fresh
    window.statistics()
    assert not window.fresh


def test_a_clock_that_jumps_back_begins_anew() -> None:
    """A simulation restarted does not give a negative interval."""
    window = Window()
    for now in (10.0, 11.0, 0.0, 0.5):
        window.tick(now)
    found = window.statistics()
    assert found is not None
    assert (found.count, found.mean) == (1, 0.5)


def test_the_window_is_bounded() -> None:
    """Only the last values count."""
    window = Window(size=2)
    for value in (9.0, 1.0, 3.0):
        window.add(value)
    found = window.statistics()
    assert found is not None
    assert (found.mean, found.least, found.most, found.count) == (2.0, 1.0, 3.0, 2)
    assert delay_text(found) == "average delay: 2.000\n\tmin: 1.000s max: 3.000s std dev: 1.00000s window: 3"


def test_bandwidth_in_fitting_units() -> None:
    """Bytes, kilobytes or megabytes a second by size, and it decays when nothing comes."""
    bandwidth = Bandwidth()
    bandwidth.add(0.0, 1000)
    bandwidth.add(1.0, 3000)
    assert (
        bandwidth_text(bandwidth, 1.0)
        == "average: 4.00KB/s\n\tmean: 2.00KB min: 1.00KB max: 3.00KB window: 2"
    )
    assert (
        bandwidth_text(bandwidth, 8.0)
        == "average: 500.00B/s\n\tmean: 2000.00B min: 1000.00B max: 3000.00B window: 2"
    )


def test_table() -> None:
    """Titles are centred, cells left-aligned, three blanks between."""
    assert table(["topic", "rate"], [["/a", "10.0"], ["/long_name", "1"]]) == (
        "  topic      rate\n=================\n/a           10.0\n/long_name   1   \n"
    )
