"""The place that a command line asks for: marks by name, from options and files, on a map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import MarkFile
from woosh_pure.sim.site import built_in_site, mark_of, site_of


@pytest.fixture
def small_map(tmp_path: Path) -> Path:
    """8 m by 6 m: of the hall's marks A1, B2, C1 and W1 lie in it, and W1 in a wall."""
    cells = np.zeros((60, 80), np.int8)
    grid = GridMap(cells, 0.1, Pose2D(-3.0, -3.5, 0.0))
    row, column = grid.cell_of(1.0, -1.5)
    cells[row - 1 : row + 2, column - 1 : column + 2] = 100
    grid.save(tmp_path / "small.yaml")
    return tmp_path / "small.yaml"


@pytest.fixture
def list_file(tmp_path: Path) -> Path:
    marks = MarkFile(tmp_path / "marks.json")
    marks.put("货架", Pose2D(2.0, 0.5, 1.0))
    marks.put("A1", Pose2D(2.5, 0.0, 0.0))
    marks.put("a note without a place")
    marks.save()
    return marks.path


@pytest.mark.parametrize(
    ("text", "name", "x", "y", "degrees"),
    [
        ("DOCK=1.5,-2,90", "DOCK", 1.5, -2.0, 90.0),
        ("货架 3=0,0,-180", "货架 3", 0.0, 0.0, -180.0),
        ("a=b=1,+.5,450", "a=b", 1.0, 0.5, 90.0),
    ],
)
def test_a_mark_is_a_name_and_a_pose_in_degrees(
    text: str, name: str, x: float, y: float, degrees: float
) -> None:
    found, pose = mark_of(text)
    assert (found, pose.x, pose.y) == (name, x, y)
    assert math.cos(pose.yaw - math.radians(degrees)) == pytest.approx(1.0)


@pytest.mark.parametrize("text", ["", "A", "A=", "=1,2,3", " =1,2,3", "A=1,2", "A=1,2,3,4", "A=1,2,x", "A=1,2,nan", "A=1_0,2,3", "A=１,2,3", "A=1e999,0,0", "A=1, 2, 3"])  # fmt: skip
def test_what_is_written_otherwise_is_shown_the_form(text: str) -> None:
    with pytest.raises(ValueError, match="NAME=X,Y,YAW"):
        mark_of(text)


def test_nothing_asked_for_is_the_built_in_hall() -> None:
    assert site_of() is None


def test_marks_come_to_the_hall_and_one_of_that_name_is_moved() -> None:
    site = site_of(None, ["N=2,0,90", "C1=0,1,0"])
    assert site is not None
    assert set(site.marks) == {*built_in_site().marks, "N"}
    assert site.marks["N"].pose.yaw == pytest.approx(math.pi / 2)
    assert site.marks["C1"].pose.x == 0.0
    assert site.marks["C1"].charger


def test_a_map_keeps_the_marks_that_lie_in_it_on_free_ground(small_map: Path) -> None:
    site = site_of(small_map, ["D=0,0,0"])
    assert site is not None
    assert set(site.marks) == {"A1", "B2", "C1", "D"}
    assert site.grid.width == 80


def test_files_come_before_options(list_file: Path) -> None:
    site = site_of(None, ["A1=3,0,0"], [list_file])
    assert site is not None
    assert site.marks["货架"].pose == Pose2D(2.0, 0.5, 1.0)
    assert site.marks["A1"].pose.x == 3.0
    assert "a note without a place" not in site.marks


def test_a_mark_in_a_wall_or_beside_the_map_is_refused(small_map: Path, list_file: Path) -> None:
    for arguments in ((small_map, ["W=1,-1.5,0"]), (small_map, ["W=99,0,0"]), (None, ["W=-5,0,0"])):
        with pytest.raises(ValueError, match=r"--mark W=.* is in a wall or outside the map, which is \d+"):
            site_of(*arguments)
    with pytest.raises(FileNotFoundError, match="no such file"):
        site_of(None, [], [list_file.with_name("nothing.json")])
