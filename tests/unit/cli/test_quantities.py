"""Metres and degrees as people type them: with a unit, with a decimal comma, with a blank between."""

from __future__ import annotations

import argparse
import math

import pytest

from rosproto.cli import NotANumber, Parser, degrees, metres


@pytest.mark.parametrize(
    ("text", "value"),
    [("1", 1.0), ("1m", 1.0), ("1 m", 1.0), ("50cm", 0.5), ("-7 mm", -0.007), ("0,5", 0.5), ("-0,5m", -0.5), ("2米", 2.0), (".5", 0.5)],
)  # fmt: skip
def test_metres_have_a_unit_or_none(text: str, value: float) -> None:
    assert metres(text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [("90", 90.0), ("-90°", -90.0), ("45deg", 45.0), ("3.14159265rad", 180.0), ("30 度", 30.0)],
)
def test_degrees_have_a_unit_or_none(text: str, value: float) -> None:
    assert degrees(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["5ft", "90°", "1s", "1mm2"])
def test_another_unit_is_told_what_is_expected(text: str) -> None:
    with pytest.raises(NotANumber, match=r"plain decimal|expected metres, such as 0\.5, 50cm, 1m"):
        metres(text)


@pytest.mark.parametrize("text", ["1,500", "-1,000", "1,2,3", "1.000,5", "nan", "inf", "", "m"])
def test_what_could_mean_two_numbers_is_none(text: str) -> None:
    """1,500 is one and a half to some, and fifteen hundred to others: a robot drives by neither."""
    with pytest.raises((NotANumber, argparse.ArgumentTypeError)):
        metres(text)


def parsed(*words: str) -> argparse.Namespace:
    parser = Parser(prog="turn")
    parser.add_argument("angle", type=degrees)
    parser.add_argument("--pose", nargs=3)
    found: argparse.Namespace = parser.parse_args(words)
    return found


@pytest.mark.parametrize(
    "words", [["-90°"], ["-90", "°"], ["-90deg"], ["-90,0"], ["-1.5707963267948966rad"], ["--", "-90"]]
)
def test_a_negative_number_with_a_unit_is_no_option(words: list[str]) -> None:
    assert parsed(*words).angle == pytest.approx(-90.0)


def test_options_keep_their_values_and_mistakes_their_errors(capsys: pytest.CaptureFixture[str]) -> None:
    found = parsed("--pose", "-1m", "-2,5", "-90°", "12")
    assert [metres(found.pose[0]), metres(found.pose[1]), degrees(found.pose[2])] == [-1.0, -2.5, -90.0]
    assert found.angle == 12.0
    with pytest.raises(SystemExit):
        parsed("90", "--psoe", "1", "2", "3")
    assert "did you mean --pose?" in capsys.readouterr().err
    assert math.isclose(parsed("90", "°").angle, 90.0)
