"""Recordings made through the web, without a robot."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="fastapi is not installed")

from rosproto import Master, Node
from rosproto.errors import BagError
from tests.support.waiting import until
from woosh_pure.web import recordings
from woosh_pure.web.recordings import Recording, RecordingManager


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
    monkeypatch.setattr(recordings, "MAX_KEPT", 1)
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


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[RecordingManager]:
    """Records what a node publishes."""
    with Master() as master, Node("/recorder", master_uri=master.uri) as node:
        chassis: Any = SimpleNamespace(node=node)
        found = RecordingManager(chassis, tmp_path)
        yield found
        found.close()


def fill_up(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    room = shutil.disk_usage(folder)
    monkeypatch.setattr("rosproto.recording.recorder.LOOK_EVERY", 0.0)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: room._replace(free=9 << 20))


def test_a_recording_ended_for_want_of_disk_says_so_and_its_seconds_stand(
    manager: RecordingManager,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Nobody has asked it to end; the log has the folder, the answer has not."""
    one = manager.begin("anna")
    assert one.as_json()["end"] == ""
    fill_up(monkeypatch, tmp_path)
    until(lambda: not one.running, what="the end of the recording")
    (told,) = [each.as_json() for each in manager.all()]
    assert (told["end"], told["running"]) == ("no-room", False)
    assert told["error"] == recordings.NO_ROOM
    assert str(tmp_path) not in str(told["error"])
    assert str(tmp_path) in caplog.text
    later = one.recorder.stats().seconds
    assert one.recorder.stats().seconds == later
    assert manager.end(one.id).as_json()["end"] == "no-room", "asking for its end later does not hide it"


def test_the_other_ends_of_a_recording(manager: RecordingManager) -> None:
    """Its longest time, and a request."""
    one = manager.begin("anna", seconds=0.05)
    until(lambda: not one.running, what="the end of the recording")
    assert one.as_json()["end"] == manager.end(one.id).as_json()["end"] == "limit"
    two = manager.begin("anna")
    assert manager.end(two.id).as_json()["end"] == "asked"
    assert two.as_json()["error"] == ""


@pytest.mark.parametrize(
    ("number", "end", "text"),
    [
        (errno.ENOSPC, "no-room", recordings.NO_ROOM),
        (errno.EIO, "not-written", recordings.NOT_WRITTEN),
    ],
)
def test_a_bag_that_cannot_be_written_and_one_without_room_differ(
    tmp_path: Path, number: int, end: str, text: str
) -> None:
    """A disk that is full in spite of the reserve is one without room, too."""
    error = BagError("cannot write", path=str(tmp_path))
    error.__cause__ = OSError(number, os.strerror(number))
    recorder: Any = SimpleNamespace(finished=True, error=error)
    one = Recording("1", "anna", recorder, tmp_path / "a.bag", 0.0)
    assert one.end == end
    recorder.stats = lambda: SimpleNamespace(seconds=1.0, bytes=0, messages=0, topics=0, dropped=0)
    assert one.as_json()["error"] == text
