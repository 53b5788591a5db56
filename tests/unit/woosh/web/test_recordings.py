"""Recordings made through the web, without a robot."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="fastapi is not installed")

from woosh_pure.web import recordings
from woosh_pure.web.recordings import RecordingManager


class FinishedRecorder:
    """A recorder that has written its bag already."""

    finished = True

    def __init__(self, node: object, path: Path, **options: object) -> None:
        path.write_bytes(b"#ROSBAG V2.0\n")


def test_an_old_bag_that_cannot_be_deleted_is_deleted_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows deletes no file that a client is downloading. The new recording begins all the same."""
    monkeypatch.setattr(recordings, "Recorder", FinishedRecorder)
    monkeypatch.setattr(recordings, "MOST_KEPT", 1)
    chassis: Any = SimpleNamespace(node=None)
    manager = RecordingManager(chassis, tmp_path)
    first = manager.begin("anna")
    unlink = Path.unlink

    def refuse(path: Path, missing_ok: bool = False) -> None:
        raise PermissionError(13, "used by another process")

    monkeypatch.setattr(Path, "unlink", refuse)
    second = manager.begin("anna")
    assert manager.get(first.id) is first
    monkeypatch.setattr(Path, "unlink", unlink)
    third = manager.begin("anna")
    assert [path.exists() for path in (first.path, second.path, third.path)] == [False, False, True]
