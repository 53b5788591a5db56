"""The line that tells how far long work on a bag has come, on a pseudo-terminal and without one."""

from __future__ import annotations

import io
import os
import re
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import create_bag, open_bag, reindex
from rosproto.cli import bag_progress, main
from rosproto.codec import message_class
from tests.support.served_bag import served

if sys.platform == "win32":
    pytest.skip("needs pseudo-terminals", allow_module_level=True)

String = message_class("std_msgs/String")


class Terminal:
    """A pseudo-terminal as stderr; collects what is written to it."""

    def __init__(self) -> None:
        import pty

        self._master, slave = pty.openpty()
        self.stream = io.TextIOWrapper(io.FileIO(slave, "w"), encoding="utf-8", write_through=True)
        self._data: list[bytes] = []
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        while True:
            try:
                self._data.append(os.read(self._master, 65536))
            except OSError:  # the other end is closed
                return

    def text(self) -> str:
        """All that was written, once nobody can write any more."""
        self.stream.close()
        self._thread.join(5)
        os.close(self._master)
        return b"".join(self._data).decode()


def slow(progress: Any) -> Any:
    """The work here is short: time for a look at the line."""

    def slower(*arguments: Any) -> None:
        progress(*arguments)
        time.sleep(0.003)

    return slower


def shown(*words: object) -> tuple[int, str]:
    """Run `rosproto bag ...` where the line is shown at once: exit code, and stderr."""
    terminal = Terminal()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("step", "at", "go_on"):
            patch.setattr(bag_progress.Progress, name, slow(getattr(bag_progress.Progress, name)))
        patch.setattr(sys, "stderr", terminal.stream)
        patch.setattr(bag_progress, "FIRST_AFTER", 0.0)
        patch.setattr(bag_progress, "EVERY", 0.001)
        code = main(["bag", *map(str, words)])
    return code, terminal.text()


def lines(text: str) -> list[str]:
    """What stood in the line, one after the other."""
    return [line.rstrip() for line in text.split("\r") if line.strip()]


def a_bag(path: Path, *, mcap: bool = False) -> bytes:
    """300 chunks; its bytes."""
    with create_bag(path, chunk_bytes=1000, mcap=mcap) as bag:
        for number in range(300):
            bag.write("/said", String(data=f"{number:01000}"), 1000.0 + number)
    return path.read_bytes()


def unclosed(path: Path) -> Path:
    """A bag as a recorder that died left it: nothing says where its chunks are."""
    data = a_bag(path)
    with open_bag(path) as bag:
        end = bag.chunks[-1].pos + 500
    head = data[:4096].replace(data[:4096].split(b"index_pos=")[1][:8], bytes(8), 1)
    path.write_bytes(head + data[4096:end])
    return path


@pytest.mark.parametrize(
    "words",
    [
        "info run.bag",
        "check run.bag",
        "reindex run.bag",
        "reindex --output-dir out run.bag",
        "fix run.bag new.bag",
        "filter run.bag new.bag",
        "merge new.bag run.bag",
        "compress run.bag",
        "export run.bag csv",
    ],
)
def test_a_bag_that_was_never_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str) -> None:
    """Share, speed and what is left while it is scanned; the line is taken away at the end."""
    monkeypatch.chdir(tmp_path)
    unclosed(Path("run.bag"))
    Path("out").mkdir()
    _, text = shown(*words.split())
    assert any(
        re.fullmatch(r"(opening|mending) \S*run.bag: \d+ % \(\d+\.\d .B/s, \d+ s left\)", line)
        for line in lines(text)
    ), text
    assert text.endswith("\r") or "\r" + " " * 20 in text
    assert ("copying run.bag: " in text) == ("--output-dir" in words)
    assert ("saving run.bag: " in text) == words.startswith("fix")


@pytest.mark.parametrize("words", ["info left.mcap", "check left.mcap", "convert left.mcap new.bag"])
def test_an_mcap_file_that_was_never_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str
) -> None:
    """Scanned as well."""
    pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
    monkeypatch.chdir(tmp_path)
    data = a_bag(Path("left.mcap"), mcap=True)
    Path("left.mcap").write_bytes(data[: len(data) * 3 // 4])
    _, text = shown(*words.split())
    assert any(re.match(r"opening left.mcap: \d+ % \(.* s left\)", line) for line in lines(text)), text


def test_reindex_scans_once(tmp_path: Path) -> None:
    """The share grows, and reaches the whole; what stands in the cut-off chunk is kept all the same."""
    bag = unclosed(tmp_path / "run.bag")
    told: list[tuple[int, int]] = []
    assert reindex(bag, scanning=lambda done, total: told.append((done, total))).messages == 299
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1]
    assert len(told) > 250


@pytest.mark.parametrize(
    "words",
    [
        "info {}",
        "check {}",
        "export {} csv -o out",
        "convert {} new.bag",
        "filter {} new.bag",
        "fix {} new.bag",
    ],
)
def test_a_bag_behind_a_url(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str) -> None:
    """The verbs that read take a URL, and show how far they are."""
    need_http()
    monkeypatch.chdir(tmp_path)
    data = a_bag(tmp_path / "run.bag")
    with served(data) as (url, _):
        code, text = shown(*words.format(url).split())
    assert code == 0, text
    assert any(" s left)" in line for line in lines(text)), text
    if "new.bag" in words:
        with open_bag("new.bag") as bag:
            assert bag.message_count == 300


def test_a_server_that_takes_its_time(tmp_path: Path) -> None:
    """Nothing has come yet, nobody knows what is left: how long it has taken is shown even so, and taken away."""
    from tests.support.terminal import Terminal as ProcessTerminal

    need_http()
    go_on = threading.Event()
    with (
        served(a_bag(tmp_path / "run.bag"), hold=go_on) as (url, _),
        ProcessTerminal("bag", "info", "--plain", url, module="rosproto", columns=120) as terminal,
    ):
        terminal.wait_for(lambda text: re.search(r"opening http://\S+/run.bag: \d+ s", text) is not None)
        go_on.set()
        assert terminal.exit_code() == 0
        text = terminal.wait_for("300 msgs")
    assert "opening" not in text


def test_a_long_name_leaves_room_for_the_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In 40 columns its beginning is left out."""
    monkeypatch.setenv("COLUMNS", "40")
    _, text = shown("check", unclosed(tmp_path / ("long" * 20 + ".bag")))
    assert all(len(line) < 40 for line in lines(text) if "left)" in line)
    assert any(re.fullmatch(r"\.\.\..*long.bag: \d+ % \(.* s left\)", line) for line in lines(text)), text


def test_none_where_it_is_no_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log gets no line that is written over, nor does who asked for quiet."""
    monkeypatch.setattr(bag_progress, "FIRST_AFTER", 0.0)
    assert main(["bag", "reindex", str(unclosed(tmp_path / "run.bag"))]) == 0
    assert capsys.readouterr().err == ""
    assert shown("reindex", "-q", unclosed(tmp_path / "again.bag")) == (0, "")


def test_none_among_what_is_printed(tmp_path: Path) -> None:
    """`filter --print` has lines of its own."""
    a_bag(tmp_path / "run.bag")
    _, text = shown("filter", tmp_path / "run.bag", tmp_path / "new.bag", "True", "--print", "m.data")
    assert "new.bag" not in text


def need_http() -> None:
    pytest.importorskip("fsspec", reason="fsspec is not installed (extra remote)")
    pytest.importorskip("aiohttp", reason="aiohttp, which fsspec needs for http, is not installed")
