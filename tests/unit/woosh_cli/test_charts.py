"""Map pictures that say how large things are: grid, numbers, scale, marks; and what the scan leaves free."""

from __future__ import annotations

import math

import numpy as np
import pytest

from woosh_pure.cli.canvas import GOAL, Picture
from woosh_pure.cli.chart import BOTTOM, LEFT, RIGHT, TOP, step_of
from woosh_pure.cli.commands.scan import _word, free_ways, nearest_of
from woosh_pure.cli.letters import _GLYPHS, can_draw, put_text, text_mask
from woosh_pure.cli.picture import PATH, chart_of
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import UserMark

GRID = (206, 218, 232)


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
    metre = round(Picture(hall).pixels_per_metre)
    assert inner.shape[:2] == (5 * metre, 10 * metre)
    lines = np.flatnonzero((inner[7] == GRID).all(axis=1))
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
    line = (inner == GRID).all(axis=2)
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
    assert (pixels == GOAL).all(axis=2).any()
    assert (pixels == PATH).all(axis=2).any()
    assert (chart_of(hall)[0] != GOAL).any(axis=2).all()


def test_letters() -> None:
    """Each is five dots high and of one width; small ones are capitals; what is missing is a question mark."""
    assert all(len(rows) == 5 and len({len(row) for row in rows}) == 1 for rows in _GLYPHS.values())
    assert len({"/".join(rows) for rows in _GLYPHS.values()}) == len(_GLYPHS)
    assert (text_mask("a1") == text_mask("A1")).all()
    assert (text_mask("库") == text_mask("?")).all()
    assert text_mask("10 m", 3).shape[0] == 15
    assert can_draw("Dock-3 (a/b)")
    assert not can_draw("仓库")


def test_text_is_cut_at_the_edges() -> None:
    pixels = np.full((8, 8, 3), 255, np.uint8)
    for left, top in ((-3, -3), (5, 5), (50, 50), (-50, -50)):
        put_text(pixels, "M8", left, top, on_paper=True)
    assert (pixels < 255).any()


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
    found = [_word(d) for d in (0, 44, 90, 179, -179, -90, -45, -10)]
    assert found == ["ahead", "ahead left", "left", "behind", "behind", "right", "ahead right", "ahead"]
