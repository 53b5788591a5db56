"""Several curves over time in a terminal."""

from __future__ import annotations

import math
import re

from rosproto.cli.bag_info import ASCII_BARS, curve
from rosproto.cli.echo import PlotSamples


def two() -> PlotSamples:
    """One that rises and one that falls, ten samples over nine seconds."""
    curves = PlotSamples(["/a", "/b"])
    for i in range(10):
        curves.add(0, 100.0 + i, float(i))
        curves.add(1, 100.0 + i, 9.0 - i)
    return curves


def test_each_curve_has_its_sign_and_the_axes_their_numbers() -> None:
    lines = two().picture(42, 11, ascii_only=True).splitlines()
    assert len(lines) == 11
    assert lines[0].startswith("9 |")
    assert lines[9].startswith("0 |")
    assert lines[0].rstrip()[-1] == "*"  # /a ends at the top
    assert lines[9].rstrip()[-1] == "+"
    assert lines[0][3] == "+"  # /b begins there
    assert lines[10].split() == ["-9", "s", "-4.5", "s", "now"]
    assert two().legend(False) == ["* /a  9", "+ /b  0"]


def test_time_runs_by_the_stamps_not_by_the_count() -> None:
    """A curve that is silent for a while has a gap."""
    curves = PlotSamples(["/a"])
    for moment in (0.0, 1.0, 9.0, 10.0):
        curves.add(0, moment, 1.0)
    row = curves.picture(45, 2, ascii_only=True).splitlines()[0].split("|")[1]
    assert [match.start() for match in re.finditer(r"\*", row)] == [0, 4, 37, 41]


def test_old_samples_leave_and_a_clock_that_jumps_back_begins_anew() -> None:
    curves = PlotSamples(["/a"], seconds=5.0)
    for moment in range(100):
        curves.add(0, float(moment), float(moment))
    assert curves.picture(40, 4, ascii_only=True).splitlines()[2].startswith("94 |")
    curves.add(0, 3.0, 7.0)
    assert curves.picture(40, 4, ascii_only=True).startswith("7 |*")


def test_colours_and_braille() -> None:
    text = two().picture(42, 11, coloured=True)
    assert "\x1b[36m" in text
    assert "\x1b[33m" in text
    assert any(0x2800 < ord(c) <= 0x28FF for c in text)
    assert two().legend(True)[1].startswith("\x1b[33m")


def test_nothing_finite_is_said() -> None:
    curves = PlotSamples(["/a", "/b"])
    assert curves.picture(40, 5) == "(no finite values yet)"
    curves.add(0, 1.0, math.nan)
    assert curves.picture(40, 5) == "(no finite values yet)"
    assert curves.legend(False)[1] == "+ /b  nothing yet"
    curves.add(1, 1.0, 2.0)
    assert "2" in curves.picture(40, 5)


def test_the_curve_of_a_rate_begins_at_zero() -> None:
    """The bars rise with the numbers; a constant rate is a line of full height."""
    assert curve([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert curve([0, 7], ASCII_BARS) == "_#"
    assert curve([2, 2]) == "██"
    assert curve([0, 0]) == "▁▁"
