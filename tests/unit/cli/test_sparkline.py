"""Small pictures of numbers."""

from __future__ import annotations

import math

from rosproto.cli.bag_info import sparkline


def test_low_to_high() -> None:
    """The bars rise with the values."""
    assert sparkline([0, 1, 2, 3, 4, 5, 6, 7]) == "▁▂▃▄▅▆▇█"
    assert sparkline([0, 7], ascii_only=True) == "_#"


def test_odd_values() -> None:
    """Equal, missing and no values are drawn without an error."""
    assert sparkline([2, 2]) == "▁▁"
    assert sparkline([1, math.nan, 2]) == "▁ █"
    assert sparkline([]) == ""
    assert sparkline([math.nan]) == " "


def test_width_averages_neighbours() -> None:
    """Many values fit a narrow line."""
    assert sparkline([0, 0, 1, 1], width=2) == "▁█"
