"""Map pictures that say how large things are: grid, numbers, scale, marks; and what the scan leaves free."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from tests.support.png import read_png
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import UserMark
from woosh_pure.maps.picture import BOTTOM, LEFT, LINES, MARK, PATH, RIGHT, TOP, chart_of, chart_png, step_of
from woosh_pure.readings import free_ways, nearest_of, side_of

pytest.importorskip("PIL", reason="needs the extra `cli`")


@pytest.fixture
def hall() -> GridMap:
    """10 m by 5 m, its corner at (-2, -1)."""
    return GridMap(np.zeros((100, 200), np.int8), 0.05, Pose2D(-2.0, -1.0))


@pytest.mark.parametrize(
    ("metre", "step"), [(40.0, 1.0), (100.0, 0.5), (39.0, 2.0), (4.0, 10.0), (0.5, 100.0), (1000.0, 0.05)]
)
def test_lines_of_the_grid_stand_apart(metre: float, step: float) -> None:
    assert step_of(metre) == pytest.approx(step)


def test_a_chart_has_lines_at_whole_metres(hall: GridMap) -> None:
    pixels, notes = chart_of(hall)
    inner = pixels[TOP:-BOTTOM, LEFT:-RIGHT]
    assert notes == []
    metre = 40  # two pixels for each cell: 200 cells become at least 400 pixels
    assert inner.shape[:2] == (5 * metre, 10 * metre)
    lines = np.flatnonzero((inner[7] == LINES).all(axis=1))
    assert (lines % metre == 0).all()
    assert len(lines) == 9
    assert (pixels[-BOTTOM + 5 :] < 100).any(), "numbers and the scale below it"
    assert (pixels[:, : LEFT - 8] < 100).any(), "numbers at the left"


def test_walls_hide_the_grid() -> None:
    wall = GridMap(np.full((100, 100), 100, np.int8), 0.05)
    assert (chart_of(wall)[0][TOP:-BOTTOM, LEFT:-RIGHT] == 0).all()


def test_a_turned_map_has_a_turned_grid() -> None:
    turned = GridMap(np.zeros((100, 100), np.int8), 0.05, Pose2D(0.0, 0.0, math.pi / 4))
    inner = chart_of(turned)[0][TOP:-BOTTOM, LEFT:-RIGHT]
    line = (inner == LINES).all(axis=2)
    assert 0.02 < line.mean() < 0.15
    assert not line.all(axis=0).any(), "no line is upright"


def test_marks_are_drawn_and_those_without_letters_numbered(hall: GridMap) -> None:
    marks = [
        UserMark("A1", Pose2D(1.0, 1.0)),
        UserMark("仓库", Pose2D(4.0, 2.0)),
        UserMark("nowhere"),
        UserMark("far", Pose2D(99.0, 0.0)),
    ]
    pixels, notes = chart_of(hall, marks=marks, path=[Pose2D(0.0, 0.0), Pose2D(2.0, 0.0)])
    assert notes == ["#1 in the picture: 仓库"]
    assert (pixels == MARK).all(axis=2).any()
    assert (pixels == PATH).all(axis=2).any()
    assert (chart_of(hall)[0] != MARK).any(axis=2).all()


def test_without_pillow_there_is_the_plain_map_and_a_sentence(
    hall: GridMap, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "PIL", None)
    pixels = read_png(chart_png(hall, Output(as_json=False), marks=False, pose=Pose2D(0.0, 0.0)))
    assert pixels.shape[:2] == (200, 400)
    assert 'pip install ".[cli]"' in capsys.readouterr().out


# -- scan ----------------------------------------------------------------------------------------------------


def test_a_wall_beside_the_lane_is_not_ahead() -> None:
    """Three metres are free ahead, although a pillar stands 0.73 m away at 40 degrees."""
    pillar = (0.73 * math.cos(math.radians(40)), 0.73 * math.sin(math.radians(40)))
    points = np.array([pillar, (3.2, 0.1), (-1.0, 0.0), (0.0, -2.0)])
    ways = free_ways(points, 0.7)
    assert ways == {"ahead": 3.2, "left": math.inf, "right": 2.0, "behind": 1.0}
    assert free_ways(points, 1.0)["ahead"] == pytest.approx(pillar[0])
    distance, degrees = nearest_of(points) or (0.0, 0.0)
    assert (distance, degrees) == (pytest.approx(0.73), pytest.approx(40.0))
    assert nearest_of(np.empty((0, 2))) is None


def test_sides_in_words() -> None:
    found = [side_of(d) for d in (0, 44, 90, 179, -179, -90, -45, -10)]
    assert found == ["ahead", "ahead left", "left", "behind", "behind", "right", "ahead right", "ahead"]
