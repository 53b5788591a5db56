"""`Site`: the map, marks and start of the simulated robot; the built-in hall, and sites from files. Pure."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from rosproto.sentence import Sentence, say
from woosh_pure.geometry import Pose2D, normalize_angle
from woosh_pure.maps.gridmap import OCCUPIED, GridMap
from woosh_pure.maps.marks import MarkFile, UserMark

__all__ = ["Mark", "Site", "built_in_site", "mark_of", "not_free", "site_of"]


@dataclass(frozen=True, slots=True)
class Mark:
    """A mark of the map.

    Attributes:
        pose: Its pose in the map.
        charger: Whether it is a charging dock.
        waits: Whether a task waits here until it is interrupted (task state 5).
    """

    pose: Pose2D
    charger: bool = False
    waits: bool = False


@dataclass(frozen=True)
class Site:
    """A map, its marks, and the robot's pose at power-up."""

    grid: GridMap
    marks: dict[str, Mark] = field(default_factory=dict)
    start: Pose2D = Pose2D(0.0, 0.0)  # noqa: RUF009  (frozen)

    def user_marks(self) -> dict[str, UserMark]:
        """Return the marks as a user's list has them, by name."""
        return {name: UserMark(name, mark.pose, charger=mark.charger) for name, mark in self.marks.items()}


_HALL = """
########################
#......................#
#......................#
#......##........##....#
#......##........##....#
#......................#
#......................#
#..........####........#
#......................#
#......................#
#......##........##....#
#......##........##....#
#......................#
#......................#
#......................#
########################
"""


def built_in_site(resolution: float = 0.05) -> Site:
    """A hall of 12 m x 8 m with five pillars and seven marks; the origin (0, 0) is a free place, left of the
    centre."""
    lines = _HALL.strip().splitlines()
    coarse = np.array([[c == "#" for c in line] for line in reversed(lines)])
    factor = round(0.5 / resolution)
    cells = np.kron(coarse, np.ones((factor, factor))).astype(np.int8) * OCCUPIED
    grid = GridMap(cells, resolution, Pose2D(-2.0, -4.0, 0.0))
    marks = {
        "A1": Mark(Pose2D(3.0, 1.0, math.pi / 2)),
        "A2": Mark(Pose2D(5.5, 2.5, math.pi)),
        "B1": Mark(Pose2D(8.5, -2.0, 0.0)),
        "B2": Mark(Pose2D(4.5, -2.5, -math.pi / 2)),
        "W1": Mark(Pose2D(1.0, -1.5, 0.0), waits=True),
        "P1": Mark(Pose2D(-0.5, 2.5, 0.0)),
        "C1": Mark(Pose2D(-0.9, -3.0, math.pi), charger=True),
    }
    return Site(grid, marks, Pose2D(0.0, 0.0, 0.0))


# -- sites from the command line: a map file, and marks with yaw in degrees ----------------------------------
#
# --mark takes NAME=X,Y,YAW; --marks takes files of `woosh marks`, whose yaw is in rad.

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_MARK = re.compile(rf"(?P<name>.*\S.*)=(?P<x>{_NUMBER}),(?P<y>{_NUMBER}),(?P<yaw>{_NUMBER})", re.ASCII)


def mark_of(text: str) -> tuple[str, Pose2D]:
    """Parse a mark such as `DOCK=1.5,0.5,90` into its name and pose.

    Raises:
        ValueError: The text has another form.
    """
    found = _MARK.fullmatch(text)
    if found is None:
        wrong = "--mark {text}: expected NAME=X,Y,YAW in metres, metres and degrees, such as DOCK=1.5,0.5,90"
        raise ValueError(say(wrong, text=text))
    x, y, degrees = (float(found[key]) for key in ("x", "y", "yaw"))
    return found["name"].strip(), Pose2D(x, y, normalize_angle(math.radians(degrees)))


def site_of(
    map_file: Path | None = None, marks: Iterable[str] = (), files: Iterable[str | Path] = ()
) -> Site | None:
    """The site with a map and marks; None if no argument is given, for the built-in hall.

    The hall's marks are kept where a given map is free. Marks of the command line replace those of files.

    Args:
        map_file: YAML of map_server.
        marks: Marks in the form of `mark_of`.
        files: Mark files (`MarkFile`); entries without a pose are ignored.

    Raises:
        ValueError: A mark is invalid, or lies where the map is not free.
        FileNotFoundError: A file does not exist.
    """
    given: dict[str, tuple[str, Pose2D]] = {}
    for path in map(Path, files):
        if not path.exists():
            wrong = "--marks {path}: there is no such file; `woosh marks --file {path} add` creates one"
            raise FileNotFoundError(say(wrong, path=path))
        for mark in MarkFile(path):
            if mark.pose is not None:
                given[mark.name] = (f"--marks {path}: {mark.name}", mark.pose)
    for text in marks:
        name, pose = mark_of(text)
        given[name] = (f"--mark {text}", pose)
    if map_file is None and not given:
        return None
    site = built_in_site()
    if map_file is not None:
        grid = GridMap.load(map_file)
        site = Site(grid, {name: mark for name, mark in site.marks.items() if _is_free(grid, mark.pose)})
    for source, pose in given.values():
        if not _is_free(site.grid, pose):
            raise ValueError(not_free(source, site.grid))
    # A moved charger remains a charger.
    old = site.marks
    new = {name: replace(old.get(name, Mark(pose)), pose=pose) for name, (_, pose) in given.items()}
    return replace(site, marks={**old, **new})


def _is_free(grid: GridMap, pose: Pose2D) -> bool:
    return not grid.is_occupied(pose.x, pose.y)  # also outside the map


def not_free(source: str, grid: GridMap) -> Sentence:
    """Say that a place is not free, and how far the map reaches."""
    extent = say(
        "{wide:g} m by {high:g} m from its corner at x {x:g}, y {y:g}",
        wide=grid.width * grid.resolution,
        high=grid.height * grid.resolution,
        x=grid.origin.x,
        y=grid.origin.y,
    )
    return say("{source} is in a wall or outside the map, which is {extent}", source=source, extent=extent)
