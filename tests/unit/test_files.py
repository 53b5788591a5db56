"""Small files are read whole; devices and pipes without an end are refused."""

from __future__ import annotations

import io
import os
import re
import sys
import threading
from contextlib import nullcontext
from pathlib import Path

import pytest

from rosproto.errors import DefinitionError
from rosproto.files import read_file, read_stream, read_text, replace_file, save_file, write_file
from rosproto.msg.definition_files import FileTree
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import MarkFile
from woosh_pure.sim.site import site_of

ENDLESS = Path("/dev/zero")
endless = pytest.mark.skipif(
    sys.platform == "win32" or not ENDLESS.exists(), reason="this system has no device that never ends"
)


def test_a_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    """One byte more is an error that names the file."""
    path = tmp_path / "a.txt"
    path.write_bytes(b"one\r\ntwo\n")
    assert read_file(path, 9) == b"one\r\ntwo\n"
    assert read_text(path) == "one\ntwo\n"
    with pytest.raises(ValueError, match=r"a\.txt: more than 8 bytes"):
        read_file(path, 8)


def test_what_is_piped_in_is_read_up_to_its_limit() -> None:
    """Nothing is cut off in silence."""
    assert read_stream(io.StringIO("12345"), "standard input", 5) == "12345"
    with pytest.raises(ValueError, match="standard input: more than 4 characters"):
        read_stream(io.StringIO("12345"), "standard input", 4)


@endless
def test_what_never_ends_is_refused(tmp_path: Path) -> None:
    """Maps, their pictures, marks and definitions."""
    with pytest.raises(ValueError, match="/dev/zero: more than"):
        GridMap.load(ENDLESS)
    with pytest.raises(ValueError, match="/dev/zero: more than"):
        site_of(ENDLESS)
    (tmp_path / "map.yaml").write_text("image: /dev/zero\nresolution: 0.05\norigin: [0, 0, 0]\n")
    with pytest.raises(ValueError, match="neither PGM, PPM"):
        GridMap.load(tmp_path / "map.yaml")
    with pytest.raises(ValueError, match="/dev/zero"):
        MarkFile(ENDLESS)
    (tmp_path / "Endless.msg").symlink_to(ENDLESS)
    with pytest.raises(DefinitionError, match="more than"):
        FileTree(str(tmp_path)).read("Endless.msg")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    "head", [b"P5\n4 4\n255\n", b"P2\n4 4\n255\n", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\4\0\0\0\4"]
)
def test_a_picture_that_never_ends_is_read_as_far_as_its_head_says(tmp_path: Path, head: bytes) -> None:
    """A pipe that always gives more: the reader is done, and its writer is told so."""
    pipe = tmp_path / "map.pgm"
    os.mkfifo(pipe)
    (tmp_path / "map.yaml").write_text("image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")

    def write() -> None:
        with pipe.open("wb", buffering=0) as file:
            file.write(head)
            try:
                while True:
                    file.write(b"1 " * 32768)
            except BrokenPipeError:
                pass

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    if head.startswith(b"P"):
        assert GridMap.load(tmp_path / "map.yaml").width == 4
    else:
        with pytest.raises(ValueError, match="PNG picture is cut short"):
            GridMap.load(tmp_path / "map.yaml")
    writer.join(10)
    assert not writer.is_alive()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no /dev/full")
def test_an_error_of_writing_names_the_file(tmp_path: Path) -> None:
    """Python's own does not when the disk is full: a command could not say which file it is."""
    write_file(tmp_path / "a.txt", b"x")
    assert read_file(tmp_path / "a.txt") == b"x"
    for path in ("/dev/full", str(tmp_path)):
        with pytest.raises(OSError, match=re.escape(repr(path))) as failed:
            write_file(path, b"x")
        assert failed.value.filename == path


@pytest.mark.parametrize("durable", [False, True])
def test_a_file_is_saved_as_a_whole(tmp_path: Path, durable: bool) -> None:
    """In a folder that is made; nothing is left beside it."""
    path = tmp_path / "fleet" / "a.json"
    for data in (b"longer", b"new"):
        save_file(path, data, durable=durable)
        assert path.read_bytes() == data
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.skipif(sys.platform != "linux", reason="has no /dev/full, or nothing is full in it (Wine)")
@pytest.mark.parametrize("durable", [False, True])
def test_a_full_disk_leaves_the_saved_file_as_it_was(tmp_path: Path, durable: bool) -> None:
    """What is written goes to a file beside it first."""
    path = tmp_path / "a.json"
    save_file(path, b"old")
    (tmp_path / "a.json.new").symlink_to("/dev/full")
    with pytest.raises(OSError, match=r"a\.json\.new"):
        save_file(path, b"new", durable=durable)
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize(("platform", "attempts"), [("win32", 3), ("linux", 1)])
def test_a_file_that_another_process_reads_is_replaced_a_little_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, platform: str, attempts: int
) -> None:
    """On Windows. Elsewhere a refusal has another cause and is raised at once."""
    replace, tried = os.replace, []

    def refuse(source: Path, target: Path) -> None:
        tried.append(target)
        if len(tried) < 3:
            raise PermissionError(13, "used by another process")
        replace(source, target)

    monkeypatch.setattr(os, "replace", refuse)
    monkeypatch.setattr(sys, "platform", platform)
    new, old = tmp_path / "marks.new", tmp_path / "marks"
    new.write_text("new")
    old.write_text("old")
    with nullcontext() if platform == "win32" else pytest.raises(PermissionError):
        replace_file(new, old)
    assert len(tried) == attempts
    assert old.read_text() == ("new" if platform == "win32" else "old")
