"""The file beside /rosout_agg: Debian's lines, bounded, and no disk's trouble is the program's."""

from __future__ import annotations

import io
import logging
import threading
from pathlib import Path
from typing import Any

import pytest

from rosproto import rosout_aggregator
from rosproto.codec import message_class
from rosproto.rosout_aggregator import RosoutLog
from rosproto.time import Time


def record(text: str, level: int = 4, topics: tuple[str, ...] = ("/a", "/b")) -> Any:
    found = message_class("rosgraph_msgs/Log")(
        level=level, name="/me", msg=text, file="f.py", function="fun", line=7
    )
    found.header.stamp, found.topics = Time(12, 345), list(topics)
    return found


def test_lines_are_those_of_debians_rosout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Taken from a run of Debian's /rosout (1.15.15) with these records; further lines of a text are indented."""
    monkeypatch.setattr("rosproto.rosout_aggregator.time.time", lambda: 1795273150.25)
    log = RosoutLog(tmp_path / "rosout.log")
    log.add(record("text 0\nline two", 1, ()))
    for level in (2, 4, 8, 16):
        log.add(record(f"text {level}", level))
    log.close()
    log.close()
    assert (tmp_path / "rosout.log").read_text("utf-8") == (
        "\n\n1795273150.250000000  Node Startup\n"
        "12.000000345 DEBUG /me [f.py:7(fun)] [topics: ] text 0\n    line two\n"
        "12.000000345 INFO /me [f.py:7(fun)] [topics: /a, /b] text 2\n"
        "12.000000345 WARN /me [f.py:7(fun)] [topics: /a, /b] text 4\n"
        "12.000000345 ERROR /me [f.py:7(fun)] [topics: /a, /b] text 8\n"
        "12.000000345 FATAL /me [f.py:7(fun)] [topics: /a, /b] text 16\n"
    )


@pytest.mark.promise("cannot control a terminal or forge a line")
def test_no_text_forges_a_record(tmp_path: Path) -> None:
    """Every line that begins a record was written by us, whatever a node says, in whichever field."""
    evil = "x\n13.0 FATAL /brakes [b.py:1(f)] [topics: ] they failed\r\x1b[2J\u202e\x85y"
    log = RosoutLog(tmp_path / "rosout.log")
    found = record(evil, 2, (evil,))
    found.name, found.file, found.function = evil, evil, evil
    log.add(found)
    log.close()
    text = (tmp_path / "rosout.log").read_bytes().decode("utf-8")
    assert [line for line in text.split("\n") if line and line[0] != " "][1:] == [
        next(line for line in text.split("\n") if line.startswith("12.000000345 INFO"))
    ]
    assert not [c for c in text if c != "\n" and not c.isprintable()]


def test_a_full_file_is_numbered_and_the_eleventh_forgotten(tmp_path: Path) -> None:
    log = RosoutLog(tmp_path / "rosout.log", max_bytes=100)
    for number in range(30):
        log.add(record(f"record {number:02d} " + 60 * "x"))
    log.close()
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"rosout.log", *(f"rosout.log.{n}" for n in range(1, 11))}
    texts = [(tmp_path / f"rosout.log.{n}").read_text("utf-8") for n in range(1, 11)]
    assert "record 29" in texts[0]
    assert "record 20" in texts[9]


def test_a_disk_that_fails_is_told_once_and_tried_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = threading.Event()

    class Disk(io.FileIO):
        def write(self, data: Any) -> int:
            if full.is_set():
                raise OSError(28, "No space left on device")
            return super().write(data)

    def opened(path: str, mode: str, **options: Any) -> Any:
        options["line_buffering"] = options.pop("buffering") == 1
        return io.TextIOWrapper(Disk(path, mode), write_through=True, **options)  # type: ignore[type-var]

    monkeypatch.setattr(rosout_aggregator, "open", opened, raising=False)
    log = RosoutLog(tmp_path / "rosout.log")
    full.set()
    with caplog.at_level(logging.WARNING):
        log.add(record("lost"))
        log.add(record("lost too"))
        full.clear()
        log.add(record("kept"))
    log.close()
    assert [r.getMessage() for r in caplog.records] == [
        f"! {tmp_path / 'rosout.log'}: not written: [Errno 28] No space left on device; trying again"
    ]
    assert "kept" in (tmp_path / "rosout.log").read_text("utf-8")


def test_a_file_that_cannot_be_opened_is_an_error_at_once(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        RosoutLog(tmp_path / "nowhere" / "rosout.log")
