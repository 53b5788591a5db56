"""The list of marks of a server that was given no file: it changes as long as the server runs."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.marks import MAX_MARKS, MarkList


def test_any_objects_with_name_and_pose_are_marks() -> None:
    marks = MarkList([SimpleNamespace(name="A", pose=None), UserMark("B", charger=True)])
    assert marks.all() == [UserMark("A"), UserMark("B", charger=True)]


def test_what_is_changed_lasts() -> None:
    marks = MarkList([UserMark("A")])
    marks.add(UserMark("B", Pose2D(1.0, 2.0)))
    marks.change("A", {"name": "C", "note": "n"})
    marks.remove("B")
    assert marks.all() == [UserMark("C", None, "n")]
    assert marks.find("B") is None


def test_a_change_that_is_refused_changes_nothing() -> None:
    marks = MarkList([UserMark("A"), UserMark("B")])
    for change in ({"name": "B"}, {"name": " "}, {"on_chassis": False}):
        with pytest.raises(Problem):
            marks.change("A", change)
    assert marks.all() == [UserMark("A"), UserMark("B")]


def test_the_list_has_a_bound() -> None:
    marks = MarkList([UserMark(str(i)) for i in range(MAX_MARKS)])
    with pytest.raises(Problem, match="already"):
        marks.add(UserMark("one more"))
