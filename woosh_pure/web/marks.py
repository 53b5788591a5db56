"""The list of marks of a server, from objects or from a file that it reads and writes.

The robot names its own marks by its Robot API, if it has one (`woosh_pure/web/robot_site.py`). A goal for a
saved mark drives to its pose; it uses the chassis's own task only if the mark is one of the chassis's map.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Protocol

from rosproto.logs import get_logger
from rosproto.sentence import say
from rosproto.text import printable
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile, UserMark
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.snapshot import pose_part

MAX_MARKS = 1000
_logger = get_logger("woosh_pure.web")


def mark_part(mark: UserMark) -> dict[str, object]:
    """Return a mark as the API sends it; x, y and yaw are null if the pose is not known."""
    pose = None if mark.pose is None else pose_part(mark.pose)
    return {
        "name": printable(mark.name),
        **(pose or dict.fromkeys(("x", "y", "yaw"))),
        "charger": mark.charger,
        "note": printable(mark.note),
        "on_chassis": mark.on_chassis,
        "source": mark.source,
    }


class NamedPlace(Protocol):
    """What a mark may be given as, such as a `UserMark` or a mark of the simulator."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def pose(self) -> Pose2D | None:
        """Its pose in the map, if it is known."""


class MarkList:
    """The marks of one site. Robots of one site share it. Safe from any thread; it reads and writes a file.

    Args:
        given: A `MarkFile`, which is read again when it has changed, and written; or any objects with `name`
            and `pose`, whose changes last as long as the server.
    """

    def __init__(self, given: Iterable[NamedPlace] = ()) -> None:
        self._file = given if isinstance(given, MarkFile) else None
        self._lock = threading.Lock()
        self._marks = {mark.name: mark for mark in map(_as_mark, () if self._file else given)}

    def all(self) -> list[UserMark]:
        """All marks.

        Raises:
            Problem: The file cannot be read now.
        """
        with self._lock:
            return list(self._now().values())

    def find(self, name: str) -> UserMark | None:
        """Return the mark of that name; None if there is none.

        Raises:
            Problem: The file cannot be read now.
        """
        with self._lock:
            return self._now().get(name)

    def get(self, name: str) -> UserMark:
        """Return the mark of that name.

        Raises:
            Problem: There is no such mark, or the file cannot be read now.
        """
        with self._lock:
            return _require(self._now(), name)

    def add(self, mark: UserMark) -> UserMark:
        """Add a mark.

        Raises:
            Problem: It has no name or no place, its name is in use, there are too many marks, or saving
                failed.
        """
        mark = _checked(mark, 422)
        with self._changing() as marks:
            _require_free(marks, mark.name)
            if len(marks) >= MAX_MARKS:
                raise Problem(409, "there are {maximum} marks already", "too-many-marks", maximum=MAX_MARKS)
            marks[mark.name] = mark
        return mark

    def change(self, name: str, changes: Mapping[str, Any]) -> UserMark:
        """Change a mark: its name, pose, note ...

        Raises:
            Problem: There is no such mark, another has the new name, it would have no place, or saving
                failed.
        """
        with self._changing() as marks:
            new = _checked(replace(_require(marks, name), **changes), 409)
            if new.name != name:
                _require_free(marks, new.name)
            del marks[name]
            marks[new.name] = new
        return new

    def remove(self, name: str) -> None:
        """Remove a mark from the list.

        Raises:
            Problem: There is no such mark, or saving failed.
        """
        with self._changing() as marks:
            del marks[_require(marks, name).name]

    def _now(self) -> dict[str, UserMark]:
        if self._file is None:
            return self._marks
        try:
            self._file.refresh()
        except (OSError, ValueError) as error:
            raise _not_kept("read", error) from error
        return {mark.name: mark for mark in self._file}

    @contextmanager
    def _changing(self) -> Iterator[dict[str, UserMark]]:
        """A copy of the marks to change; it is kept unless an error is raised."""
        with self._lock:
            marks = dict(self._now())
            yield marks
            if self._file is None:
                self._marks = marks
                return
            try:
                self._file.keep(marks.values())
            except OSError as error:
                raise _not_kept("written", error) from error


def _checked(mark: UserMark, without_place: int) -> UserMark:
    """The mark as it is kept.

    Args:
        without_place: Status of the problem: 422 if the request is wrong by itself, 409 if it does not fit
            the mark as it is.
    """
    mark = replace(mark, name=mark.name.strip())
    if not mark.name or mark.name != printable(mark.name):
        raise Problem(422, "name: a mark needs a name of printable characters", "invalid")
    if mark.pose is None and not mark.on_chassis:
        text = "a place needs a pose: give x and y, or here: true; only a mark of the chassis may have none"
        raise Problem(without_place, text, "invalid" if without_place == 422 else "mark")
    return mark


def _require(marks: dict[str, UserMark], name: str) -> UserMark:
    if name not in marks:
        raise Problem(404, "there is no mark {name!r:.80} on the list of this server", name=name)
    return marks[name]


def _require_free(marks: dict[str, UserMark], name: str) -> None:
    if name in marks:
        text = "there is a mark {name!r:.80} already; take another name, or change that one"
        raise Problem(409, text, "mark-exists", name=name)


def _not_kept(what: str, error: Exception) -> Problem:
    """Return a problem without the path of the file, and log the path."""
    _logger.error("! the list of marks cannot be %s: %s", say(what), error)
    text = "the list of marks cannot be {what}; the log of the server says why"
    return Problem(503, text, "marks-not-kept", what=say(what))


def _as_mark(mark: NamedPlace) -> UserMark:
    if isinstance(mark, UserMark):
        return mark
    return UserMark(mark.name, mark.pose, getattr(mark, "note", ""), getattr(mark, "charger", False))
