"""Pieces of many recordings: every message once, wherever they lie; damage costs its chunk alone."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter, Partition, create_bag, open_bag, partitions
from rosproto.cli import main
from rosproto.codec import message_class
from rosproto.errors import BagError
from tests.unit.bag.bagmaker import entries

pytest.importorskip("pyarrow", reason="pyarrow is not installed (extra arrow)")

Image = message_class("sensor_msgs/Image")
String = message_class("std_msgs/String")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three bags, one below, one of them LZ4 with a picture in each chunk."""
    (tmp_path / "below").mkdir()
    for number, name in enumerate(["a.bag", "b.bag", "below/c.bag"]):
        with BagWriter(tmp_path / name, "lz4" if number == 1 else "none", 3000) as bag:
            for i, (topic, message, stamp) in enumerate(entries(200)):
                if topic == "/chatter":
                    message = String(data=f"{name} {i}")
                bag.write(topic, message, stamp)
                if number == 1 and i % 20 == 0:
                    bag.write("/image", Image(height=1, width=5000, data=bytes(5000)), stamp)
    return tmp_path


def texts(pieces: list[Partition]) -> list[str]:
    return [text for piece in pieces for text in piece.table()["data"].to_pylist()]


@pytest.mark.parametrize("size", [1, 10_000, 1 << 30])
def test_every_message_once(folder: Path, size: int) -> None:
    """Through pickle, as another process gets them."""
    pieces = partitions(folder, "/chatter", size=size)
    pieces = pickle.loads(pickle.dumps(pieces))
    found = texts(pieces)
    expected = []
    for name in ["a.bag", "b.bag", "below/c.bag"]:
        with BagReader(folder / name) as bag:
            expected += [m.data for _, m, _ in bag.read_messages("/chatter")]
    assert found == expected
    assert sum(piece.message_count for piece in pieces) == len(expected)
    assert len(pieces) == 3 if size == 1 << 30 else len(pieces) > 3


def test_all_topics_and_mcap(folder: Path) -> None:
    """A piece has one topic; an MCAP file is cut as a bag is."""
    pytest.importorskip("mcap")
    assert main(["bag", "convert", str(folder / "b.bag"), str(folder / "b.mcap")]) == 0
    rows: dict[tuple[str, str], int] = {}
    for piece in pickle.loads(pickle.dumps(partitions([folder / "b.bag", folder / "b.mcap"], size=5000))):
        key = Path(piece.file).suffix, piece.topic
        rows[key] = rows.get(key, 0) + sum(batch.num_rows for batch in piece.batches())
    with BagReader(folder / "b.bag") as bag:
        for topic, info in bag.topics.items():
            assert rows[".bag", topic] == rows[".mcap", topic] == info.message_count


def test_patterns_and_several(folder: Path) -> None:
    """Each file once."""
    found = partitions([str(folder / "*.bag"), folder / "a.bag"], "/chatter", size=1 << 30)
    assert [Path(piece.file).name for piece in found] == ["a.bag", "b.bag"]
    deep = partitions(str(folder / "**" / "*.bag"), "/chatter", size=1 << 30)
    assert len(deep) == 3


def test_chosen_fields_and_schema(folder: Path) -> None:
    """Told without reading anything."""
    (piece,) = partitions(folder / "b.bag", "/image", fields=["width", "header.stamp"], size=1 << 30)
    assert piece.schema().names == ["receive_time", "width", "header.stamp"]
    assert piece.table().schema == piece.schema()
    assert piece.table()["width"].to_pylist() == [5000] * 10


def damage(path: Path) -> tuple[int, int]:
    """Break the third chunk; its position, and its messages on /chatter."""
    with BagReader(path) as bag:
        chunk = bag.chunks[2]
        number = next(c.id for c in bag.connections.values() if c.topic == "/chatter")
    data = bytearray(path.read_bytes())
    data[chunk.pos + 150] ^= 0xFF
    path.write_bytes(data)
    return chunk.pos, chunk.counts[number]


def test_damage_names_the_file_and_the_byte(folder: Path) -> None:
    """In the piece that has it; the others are read."""
    position, _ = damage(folder / "b.bag")
    failed = []
    for piece in partitions(folder, "/chatter", size=1):
        try:
            piece.table()
        except BagError as problem:
            failed.append((problem.path, problem.offset))
    assert failed == [(str(folder / "b.bag"), position)]


def test_damage_left_out_costs_its_chunk(folder: Path) -> None:
    """And nothing else of its piece."""
    whole = len(texts(partitions(folder, "/chatter")))
    _, lost = damage(folder / "b.bag")
    assert lost > 0
    assert len(texts(partitions(folder, "/chatter", damaged="skip"))) == whole - lost


@pytest.mark.parametrize(("name", "number"), [("b.bag", 0), ("b.mcap", 1)])
def test_damage_that_a_scan_goes_around_is_told(folder: Path, name: str, number: int) -> None:
    """Without the index at the end nobody would miss what a chunk in the middle had."""
    path = folder / name
    if name == "b.mcap":
        pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")
        with open_bag(folder / "b.bag") as bag, create_bag(path, "lz4", 1000) as copy:
            for topic, raw, stamp in bag.read_messages(raw=True):
                copy.write(topic, raw, stamp)
    with open_bag(path) as bag:
        position, end = bag.chunks[number].pos, bag.chunks[-1].pos
    whole = path.read_bytes()
    path.write_bytes(whole[: end + 40])
    # As a recorder leaves it that was killed: nothing before that is missing.
    cut = len(texts(partitions(path, "/chatter")))
    data = bytearray(whole[: end + 40])
    data[position + 150] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(BagError, match=f"messages are missing .*byte {position}") as caught:
        partitions(path, "/chatter")
    assert caught.value.path == str(path)
    assert 0 < len(texts(partitions(path, "/chatter", damaged="skip"))) <= cut


def test_fsspec_places(folder: Path) -> None:
    """Files, folders and patterns behind a URL; fewer than twice the bytes of the chunks are fetched."""
    fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed (extra remote)")
    memory = fsspec.filesystem("memory")
    for name in ("a.bag", "b.bag"):
        memory.pipe(f"/runs/{name}", (folder / name).read_bytes())
    try:
        expected = texts(partitions([folder / "a.bag", folder / "b.bag"], "/chatter"))
        for place in ("memory://runs", "memory://runs/*.bag", ["memory://runs/a.bag", "memory://runs/b.bag"]):
            assert texts(pickle.loads(pickle.dumps(partitions(place, "/chatter")))) == expected
        with pytest.raises(BagError, match="no file matches"):
            partitions("memory://runs/*.mcap")
        with pytest.raises(BagError, match="cannot be opened"):
            partitions("memory://runs/no.bag")
        with pytest.raises(BagError, match="fsspec cannot reach"):
            partitions("nowhere://runs/no.bag")
    finally:
        memory.rm("/runs", recursive=True)


@pytest.mark.parametrize(
    ("options", "kind", "says"),
    [
        ({"topics": "/no"}, BagError, "/chatter"),
        ({"size": 0}, ValueError, "at least 1"),
        ({"damaged": "ignore"}, ValueError, "skip"),
    ],
)
def test_what_is_refused(folder: Path, options: dict[str, Any], kind: type[Exception], says: str) -> None:
    """Each with a sentence."""
    with pytest.raises(kind, match=says):
        partitions(folder, **options)


def test_nothing_to_cut(tmp_path: Path) -> None:
    """An empty folder, a pattern without a match, no names at all: each is told apart."""
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "read.me").write_text("no bag")
    for files, says in (
        (tmp_path / "notes", "no file in there ends in .bag or .mcap"),
        (tmp_path / "*.bag", "no file matches"),
        (tmp_path / "none.bag", "No such file"),
        ([], "no files were named"),
    ):
        with pytest.raises(BagError, match=says):
            partitions(files)


def test_a_file_that_is_no_recording(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """In a folder it stops everything, unless damage is skipped: then the log names it. One that is named is meant."""
    with BagWriter(tmp_path / "a.bag") as bag:
        bag.write("/said", String(data="hello"), 1.0)
    for name, content in (("b.bag", b""), ("c.mcap", b"\x89MCAP"), ("d.bag", b"<html>")):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(BagError, match=r"b\.bag: the file is empty"):
        partitions(tmp_path)
    assert sum(piece.message_count for piece in partitions(tmp_path, damaged="skip")) == 1
    assert all(name in caplog.text for name in ("b.bag", "c.mcap", "d.bag"))
    with pytest.raises(BagError, match="the file is empty"):
        partitions(tmp_path / "b.bag", damaged="skip")
