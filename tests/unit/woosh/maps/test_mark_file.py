"""The list of marks as several programs keep it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile, UserMark


def test_what_another_program_has_saved_is_read_again(tmp_path: Path) -> None:
    mine, other = MarkFile(tmp_path / "marks.json"), MarkFile(tmp_path / "marks.json")
    other.put("A", Pose2D(1.0, 2.0, 0.5))
    other.save()
    mine.refresh()
    assert mine["A"].pose == Pose2D(1.0, 2.0, 0.5)
    os.unlink(mine.path)
    mine.refresh()
    assert len(mine) == 0


def test_a_file_that_makes_no_sense_is_told_each_time_and_what_was_read_stays(tmp_path: Path) -> None:
    marks = MarkFile(tmp_path / "marks.json")
    marks.put("A")
    marks.save()
    marks.path.write_text("{half of it")
    for _ in range(2):
        with pytest.raises(ValueError, match="not a mark file"):
            marks.refresh()
    assert marks.names == ["A"]


def test_what_is_known_of_a_mark_stays_when_its_pose_is_replaced(tmp_path: Path) -> None:
    """`woosh marks add` knows nothing of a charger, or of what the page has saved."""
    marks = MarkFile(tmp_path / "marks.json")
    marks.keep([UserMark("A", Pose2D(0.0, 0.0), "old", charger=True, on_chassis=False)])
    again = MarkFile(marks.path)
    again.put("A", Pose2D(1.0, 0.0), "new")
    again.save()
    assert list(MarkFile(marks.path)) == [UserMark("A", Pose2D(1.0, 0.0), "new", True, False)]


def test_a_list_that_cannot_be_written_is_as_before(tmp_path: Path) -> None:
    marks = MarkFile(tmp_path / "no folder" / "marks.json")
    (tmp_path / "no folder").write_text("in the way")
    with pytest.raises(OSError):
        marks.keep([UserMark("A")])
    assert len(marks) == 0


def test_each_save_writes_all_marks_in_the_layout_of_json(tmp_path: Path) -> None:
    """Marks that did not change are not formatted again, and the file looks the same."""
    marks = MarkFile(tmp_path / "marks.json")
    for change in (
        lambda: marks.put("b", Pose2D(1.0, 2.0, 0.5), 'a "quoted"\nnote'),
        lambda: marks.put("仓库", Pose2D(1.0, 2.0), on_chassis=False),
        lambda: marks.put("a"),
        lambda: marks.put("b", Pose2D(3.0, 2.0, 0.5)),
        lambda: marks.remove("a"),
        lambda: [marks.remove(name) for name in marks.names],
    ):
        change()
        marks.save()
        text = marks.path.read_text(encoding="utf-8")
        assert text == json.dumps(json.loads(text), indent=2, ensure_ascii=False, sort_keys=True) + "\n"
        assert list(MarkFile(marks.path)) == sorted(marks, key=lambda mark: mark.name)
    assert text == "{}\n"
