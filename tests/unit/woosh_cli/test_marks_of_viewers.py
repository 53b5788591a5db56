"""The list of marks that `woosh foxglove` draws and `woosh robot-api` serves."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import pytest

from woosh_pure.cli.commands.bags_and_viewers import _marks


def test_a_changed_list_is_read_again_and_stays_while_it_cannot_be(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "marks.json"
    marks = _marks(Namespace(marks=path))
    assert list(marks()) == []
    path.write_text('{"A1": {"x": 3.0, "y": 1.0, "yaw": 1.57}}')
    assert [mark.name for mark in marks()] == ["A1"]
    path.write_text("{")
    assert [mark.name for mark in marks()] == ["A1"]
    assert "not a mark file" in caplog.text
    path.unlink()
    assert list(marks()) == []


def test_a_list_that_cannot_be_read_is_told_at_the_start(tmp_path: Path) -> None:
    path = tmp_path / "marks.json"
    path.write_text("{")
    with pytest.raises(ValueError, match="not a mark file"):
        _marks(Namespace(marks=path))
