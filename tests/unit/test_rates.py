"""Rates, delays and bandwidths: the figures, and the output that scripts parse."""

from __future__ import annotations

from rosproto.rates import Bandwidth, Statistics, Window, bandwidth_text, delay_text, hz_table, hz_text


def test_a_steady_stream() -> None:
    """Ten messages a second are 10 Hz without deviation."""
    window = Window()
    for i in range(11):
        window.add(i * 0.1)
    found = window.statistics()
    assert found is not None
    assert abs(found.mean - 0.1) < 1e-9
    assert found.messages == 11
    assert hz_text(found) == "average rate: 10.000\n\tmin: 0.100s max: 0.100s std dev: 0.00000s window: 11"


def test_nothing_yet() -> None:
    """One message gives no rate, and says so."""
    window = Window()
    window.add(1.0)
    assert window.statistics() is None
    assert hz_text(None) == "no new messages"
    assert bandwidth_text(Bandwidth(), 1.0) is None


def test_fresh_tells_whether_anything_came_since() -> None:
    """A stream that ended is told from a steady one."""
    window = Window()
    window.add(0.0)
    window.add(0.5)
    assert window.fresh
    assert window.news() is not None
    assert not window.fresh
    assert window.news() is None
    assert window.statistics() is not None


def test_a_clock_that_jumps_back_begins_anew() -> None:
    """A simulation restarted does not give a negative interval."""
    window = Window()
    for now in (10.0, 11.0, 0.0, 0.5):
        window.add(now)
    found = window.statistics()
    assert found is not None
    assert (found.messages, found.mean) == (2, 0.5)


def test_the_window_is_bounded() -> None:
    """Only the last values count."""
    window = Window(3)
    for now, delay in enumerate((5.0, 9.0, 1.0, 3.0)):
        window.add(now, delay)
    found = window.statistics()
    assert found is not None
    assert (found.mean, found.minimum, found.maximum, found.messages) == (2.0, 1.0, 3.0, 3)
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
    """Titles are centred, cells left-aligned, three blanks between; a silent topic has no row."""
    steady = Statistics(0.1, 0.1, 0.1, 0.0, 11)
    assert hz_table({"/a": None}) == "no new messages"
    assert hz_table({"/a": steady, "/silent": None, "/long_name": steady}) == (
        "  topic      rate   min_delta   max_delta   std_dev   window\n"
        "============================================================\n"
        "/a           10.0   0.1         0.1         0.0       11    \n"
        "/long_name   10.0   0.1         0.1         0.0       11    \n"
    )
