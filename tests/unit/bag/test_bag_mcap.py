"""MCAP both ways: what a bag holds comes back as it was, dead recorders leave a file that opens, and damage is told."""

from __future__ import annotations

import io
import os
import signal
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter, create_bag, open_bag
from rosproto.cli import main
from rosproto.codec import encode, message_class
from rosproto.errors import BagError, RosError
from rosproto.time import Time
from tests.unit.bag.bagmaker import bag_bytes, entries

pytest.importorskip("mcap", reason="mcap is not installed (extra mcap)")

from rosproto.bag.mcap import McapReader, McapWriter

String = message_class("std_msgs/String")
COMPRESSIONS = ["none", "lz4", "zstd"]


def facts(bag: BagReader) -> list[Any]:
    """All that a conversion must keep."""
    return [
        (
            topic,
            raw.type,
            bytes(raw.data),
            raw.md5sum,
            stamp,
            raw.connection.definition,
            dict(raw.connection.header),
        )
        for topic, raw, stamp in bag.read_messages(raw=True)
    ]


def a_bag(path: Path, count: int = 60) -> None:
    """Three topics; two publishers of one, latched, remapped, with fields nobody knows."""
    with BagWriter(path, "lz4", 900) as bag:
        for number, (topic, message, stamp) in enumerate(entries(count)):
            header = {"callerid": f"/node{number % 2}", "latching": "1", "x_own": "é", "topic": "/before"}
            bag.write(topic, message, stamp, header=header if topic == "/chatter" else None)
            bag.write("/same_time", String(data=f"{number}"), stamp)


def mcap_bytes(
    what: list[Any], compression: Any = "none", chunk_bytes: int = 1500, *, close: bool = True
) -> bytes:
    file = io.BytesIO()
    writer = McapWriter(file, compression, chunk_bytes)
    for topic, message, stamp in what:
        writer.write(topic, message, stamp)
    if close:
        writer.close()
    return file.getvalue()


def read(data: bytes, **options: Any) -> BagReader:
    return open_bag(io.BytesIO(data), **options)


@pytest.mark.parametrize("compression", [[], ["--lz4"]])
def test_there_and_back(tmp_path: Path, compression: list[str]) -> None:
    """Messages, times, topics, definitions and connection headers; of both, and written by BagWriter anew."""
    one, two, three = (tmp_path / name for name in ("a.bag", "a.mcap", "b.bag"))
    a_bag(one)
    assert main(["bag", "convert", str(one), str(two), *compression]) == 0
    assert main(["bag", "convert", str(two), str(three), *compression]) == 0
    with BagReader(one) as first, open_bag(two) as middle, BagReader(three) as last:
        assert isinstance(middle, McapReader)
        assert middle.damage == []
        assert middle.indexed
        assert facts(first) == facts(middle) == facts(last)
        for bag in (middle, last):
            assert bag.message_count == first.message_count
            assert {t: i.message_count for t, i in bag.topics.items()} == {
                t: i.message_count for t, i in first.topics.items()
            }
            assert (bag.start_time, bag.end_time) == (first.start_time, first.end_time)
        records = [sorted(c.encode()[40:] for c in bag.connections.values()) for bag in (first, last)]
        assert records[0] == records[1]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_writer_is_read_like_a_bag(compression: str) -> None:
    """Every way of reading gives what a bag of the same messages gives."""
    what = entries(50)
    ours, theirs = read(mcap_bytes(what, compression)), read(bag_bytes(what))
    assert [(t, encode(m), s) for t, m, s in ours] == [(t, encode(m), s) for t, m, s in theirs]
    span = {"topics": "/cmd_vel", "start_time": Time(101), "end_time": Time(103)}
    assert [s for _, _, s in ours.read_messages(**span)] == [s for _, _, s in theirs.read_messages(**span)]
    assert ours.times("/data").tolist() == theirs.times("/data").tolist()
    assert ours.frequency("/cmd_vel") == theirs.frequency("/cmd_vel")
    assert set(ours.compression()) == {compression}
    x = "linear.x"
    assert ours.to_numpy("/cmd_vel", [x])[x].tolist() == theirs.to_numpy("/cmd_vel", [x])[x].tolist()
    found = [bag.message_at("/chatter", Time(102)) for bag in (ours, theirs)]
    assert found[0] is not None
    assert found[0] == found[1]
    pytest.importorskip("pyarrow")
    assert ours.to_arrow("/cmd_vel").read_all().drop_columns([]).num_rows == len(ours.times("/cmd_vel"))


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_cut_anywhere_it_opens(compression: str) -> None:
    """What is whole is read, in order; what is missing is said."""
    what = entries(60)
    whole = mcap_bytes(what, compression, 600)
    expected = [(t, encode(m), s) for t, m, s in what]
    for at in range(60, len(whole) - 1, 37):
        bag = read(whole[:at])
        found = [(t, bytes(r.data), s) for t, r, s in bag.read_messages(raw=True)]
        assert found == expected[: len(found)]
        assert bag.damage
        assert not bag.indexed
    assert len(found) == 60


def test_a_changed_byte_is_messages_or_a_sentence() -> None:
    """Anywhere in the file: nothing but our own errors, and never messages that were not written."""
    what = entries(20)
    whole = mcap_bytes(what, "lz4", 400)
    expected = {(t, encode(m)) for t, m, _ in what}
    strange = 0
    for at in range(8, len(whole), 11):
        data = whole[:at] + bytes([whole[at] ^ 0x41]) + whole[at + 1 :]
        try:
            bag = read(data, skip_damaged=True)
            found = [(t, bytes(r.data)) for t, r, _ in bag.read_messages(raw=True)]
        except RosError:
            continue
        strange += not {data for _, data in found} <= {data for _, data in expected}
    assert not strange


def test_a_killed_recorder_leaves_a_file_that_opens(tmp_path: Path) -> None:
    """SIGKILL in the middle of writing; all flushed messages are there."""
    path = tmp_path / "killed.mcap"
    code = (
        "import sys, time; from rosproto.bag.mcap import McapWriter; from rosproto.codec import message_class\n"
        "S = message_class('std_msgs/String'); w = McapWriter(sys.argv[1], 'zstd', 4000)\n"
        "for i in range(500): w.write('/s', S(data=f'number {i}'), float(i))\n"
        "w.flush(); w.write('/s', S(data='lost'), 501.0); print('ready', flush=True); time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code, str(path)], stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
    finally:
        os.kill(process.pid, signal.SIGKILL) if os.name == "posix" else process.kill()
        process.wait(10)
        process.stdout.close()  # type: ignore[union-attr]
    with open_bag(path) as bag:
        assert [m.data for _, m, _ in bag] == [f"number {i}" for i in range(500)]
        assert "was not finished" in bag.damage[0]


def test_messages_outside_of_chunks() -> None:
    """As some writers leave them."""
    from mcap.writer import Writer

    file = io.BytesIO()
    writer = Writer(file, use_chunking=False)
    writer.start(profile="ros1", library="test")
    schema = writer.register_schema("std_msgs/String", "ros1msg", String._full_text.encode())
    channel = writer.register_channel("/s", "ros1", schema)
    for i in range(3000):
        writer.add_message(channel, i * 10**9, encode(String(data=str(i))), i * 10**9)
    writer.finish()
    bag = read(file.getvalue())
    assert [m.data for _, m, _ in bag] == [str(i) for i in range(3000)]
    assert bag.connections[channel].md5sum == String._md5sum


@pytest.mark.promise("no chunk gives more than it declares, and a length beyond the file takes no memory")
def test_a_chunk_that_unpacks_to_more_than_it_says() -> None:
    """A gigabyte of zeros in a few bytes: refused, at the price of what the record says."""
    import lz4.frame
    import zstandard
    from mcap.data_stream import RecordBuilder
    from mcap.records import Chunk

    whole = mcap_bytes(entries(5))
    for kind, packed in (
        ("lz4", lz4.frame.compress(bytes(50_000_000))),
        ("zstd", zstandard.compress(bytes(50_000_000))),
    ):
        for size in (1000, 1 << 40):
            builder = RecordBuilder()
            Chunk(kind, packed, 1, 0, 0, size).write(builder)
            bag = read(whole[:8] + header_of(whole) + builder.end(), skip_damaged=True)
            assert bag.message_count == 0
            assert any("damaged" in line or "bytes" in line for line in bag.damage)


def header_of(data: bytes) -> bytes:
    (size,) = struct.unpack_from("<Q", data, 9)
    return data[8 : 17 + size]


@pytest.mark.promise("no chunk gives more than it declares, and a length beyond the file takes no memory")
def test_lengths_beyond_the_file_cost_nothing() -> None:
    """A record of 2**62 bytes is a record that is cut off."""
    whole = mcap_bytes(entries(5))
    bag = read(whole[:8] + header_of(whole) + b"\x06" + struct.pack("<Q", 1 << 62) + bytes(50))
    assert bag.message_count == 0
    assert "truncated" in bag.damage[-1]


def test_ros2_messages_are_listed_but_not_decoded() -> None:
    """The sentence says that there is no definition."""
    from mcap.writer import Writer

    file = io.BytesIO()
    writer = Writer(file)
    writer.start(profile="ros2", library="test")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    writer.add_message(writer.register_channel("/s", "cdr", schema), 5, b"\0\1\0\0", 5)
    writer.finish()
    bag = read(file.getvalue())
    assert list(bag.topics) == ["/s"]
    with pytest.raises(BagError, match="no usable definition"):
        list(bag)
    assert [r.data for _, r, _ in bag.read_messages(raw=True)] == [b"\0\1\0\0"]


def test_what_is_refused(tmp_path: Path) -> None:
    """Each with a sentence."""
    with pytest.raises(BagError, match="bz2"):
        create_bag(tmp_path / "a.mcap", "bz2")
    with pytest.raises(BagError, match="zstd"):
        create_bag(tmp_path / "a.bag", "zstd")
    with pytest.raises(ValueError, match="snappy"):
        McapWriter(tmp_path / "a.mcap", "snappy")  # type: ignore[arg-type]
    with McapWriter(tmp_path / "a.mcap") as writer, pytest.raises(BagError, match="UTF-8"):
        writer.write("/s", String(), 1.0, header={"callerid": "\udcff"})
    with pytest.raises(BagError, match="closed"):
        writer.write("/s", String(), 1.0)
    with pytest.raises(BagError, match="not an MCAP"):
        McapReader(io.BytesIO(bag_bytes(entries(3))))


def test_without_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The error names the extra."""
    data = mcap_bytes(entries(3))
    for name in ("mcap.writer", "mcap.exceptions"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(BagError, match=r"\.\[mcap\]"):
        read(data)
    with pytest.raises(BagError, match=r"\.\[mcap\]"):
        McapWriter(tmp_path / "a.mcap")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_a_full_disk_is_a_sentence() -> None:
    """At the next chunk, and at every write from then on."""
    writer = McapWriter("/dev/full", "none", 1000)
    with pytest.raises(BagError, match="No space left"):
        writer.write("/s", String(data="x" * 20_000), 1.0)
    with pytest.raises(BagError, match="No space left"):
        writer.write("/s", String(), 1.0)
    writer.close()


@pytest.mark.parametrize(
    "line",
    [
        "info {a}",
        "check {a}",
        "echo {a} /chatter",
        "filter {a} {b} --topics /chatter",
        "merge {b} {a} {a}",
        "export {a} csv -o {d}",
    ],
)
def test_the_verbs_take_it(tmp_path: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    """By what is in it, whatever its name is; filter writes what the new name says."""
    one, two = tmp_path / "a.bag", tmp_path / "strange.name"
    a_bag(one)
    assert main(["bag", "convert", str(one), str(tmp_path / "x.mcap")]) == 0
    (tmp_path / "x.mcap").rename(two)
    words = [word.format(a=two, b=tmp_path / "out.mcap", d=tmp_path / "csv") for word in line.split()]
    capsys.readouterr()
    assert main(["bag", *words]) == 0
    said = capsys.readouterr().out
    if words[0] == "info":
        assert "/chatter" in said
    if words[0] == "check":
        assert "sound, 120 messages" in said
    if words[0] == "echo":
        with open_bag(one) as bag:
            assert said.count("data:") == bag.topics["/chatter"].message_count
    if words[0] == "merge":
        with open_bag(tmp_path / "out.mcap") as bag, open_bag(two) as half:
            assert isinstance(bag, McapReader)
            assert bag.message_count == 2 * half.message_count
            stamps = [stamp for _, _, stamp in bag]
            assert stamps == sorted(stamps)
    if words[0] == "filter":
        with open_bag(tmp_path / "out.mcap") as bag:
            assert isinstance(bag, McapReader)
            assert list(bag.topics) == ["/chatter"]
