"""Records that no usual writer makes, put together by hand, and what else readers meet once in a thousand bags."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from struct import pack
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter, recover, reindex
from rosproto.bag.chunk import ChunkData
from rosproto.bag.compression import _up_to_damage, compressor, decompress_prefix
from rosproto.bag.message_offsets import walk
from rosproto.bag.messages import message_class_of
from rosproto.bag.records import (
    MAGIC,
    ChunkInfo,
    Connection,
    FileHeader,
    encode_contents,
    encode_fields,
    encode_index,
    encode_record,
)
from rosproto.codec import encode
from rosproto.errors import BagError
from rosproto.time import Time
from tests.unit.bag.bagmaker import String, bag_bytes, encoded, entries, plain, read

HEAD = MAGIC + FileHeader().encode()
SAID = Connection(0, "/said", "std_msgs/String", String._md5sum, String._full_text)


def message(text: str, secs: int, conn: bytes = pack("<I", 0), time: bytes | None = None) -> bytes:
    """A message record."""
    fields = {"op": b"\x02", "conn": conn, "time": pack("<II", secs, 0) if time is None else time}
    return encode_record(fields, encode(String(data=text)))


def chunk(data: bytes, compression: str = "none", **more: bytes) -> bytes:
    """A chunk record, with further header fields."""
    packed = compressor(compression)(data)
    fields = {"compression": compression.encode(), "op": b"\x05", "size": pack("<I", len(data)), **more}
    return encode_fields(fields) + pack("<I", len(packed)) + packed


def index(offsets: list[tuple[int, int]], conn: int = 0) -> bytes:
    """An index record of (secs, offset)."""
    return encode_index(conn, b"".join(pack("<III", secs, 0, offset) for secs, offset in offsets))


def closed(chunks: bytes, infos: list[ChunkInfo], connections: list[Connection]) -> bytes:
    """A bag with a table of contents that says this."""
    end = len(HEAD) + len(chunks)
    header = FileHeader(end, len(connections), len(infos)).encode()
    return MAGIC + header + chunks + encode_contents(connections, infos)


def texts(bag: BagReader) -> list[str]:
    return [m.data for _, m, _ in bag.read_messages()]


def test_records_of_unknown_op_in_a_chunk_are_passed_over():
    """A later recorder may put other things there."""
    data = (
        SAID.encode() + message("a", 1) + encode_record({"op": b"\x09", "x": b"y"}, b"new") + message("b", 2)
    )
    bag = read(HEAD + chunk(data))
    assert texts(bag) == ["a", "b"]


def test_a_record_header_longer_than_usual():
    bag = read(HEAD + chunk(SAID.encode() + message("a", 1), note=b"n" * 2000))
    assert texts(bag) == ["a"]


@pytest.mark.parametrize(
    ("conn", "time"), [(b"\0" * 5, b"\1" + b"\0" * 6), (b"\0" * 3, b"\1" + b"\0" * 8)], ids=["long", "short"]
)
def test_message_headers_whose_fields_have_the_wrong_size(conn, time):
    """The header is as long as it should be, its fields are not."""
    data = SAID.encode() + message("a", 1, conn, time)
    bag = read(HEAD + chunk(data), skip_damaged=True)
    assert bag.message_count == 0
    assert bag.damage


def test_an_index_that_points_at_another_record_is_not_believed():
    first = SAID.encode()
    data = first + message("a", 1) + message("b", 2)
    chunks = chunk(data) + index([(1, 0), (2, 0)])  # both at the connection record, which message a follows
    info = ChunkInfo(len(HEAD), 1 * 10**9, 2 * 10**9, {0: 2})
    assert sorted(texts(read(closed(chunks, [info], [SAID])))) in (["a", "a"], ["a", "b"])
    odd = encode_record({"op": b"\x09"}, b"")
    data = first + odd + message("a", 1)
    chunks = chunk(data) + index([(1, len(first))])
    info = ChunkInfo(len(HEAD), 10**9, 10**9, {0: 1})
    assert texts(read(closed(chunks, [info], [SAID]))) == ["a"]


def test_an_empty_chunk_between_others():
    data = SAID.encode() + message("a", 1)
    bag = read(HEAD + chunk(data) + chunk(b"") + chunk(message("b", 2)))
    assert texts(bag) == ["a", "b"]


def test_a_chunk_that_was_begun_and_nothing_more():
    """The recorder died before the first record was in it."""
    data = HEAD + chunk(SAID.encode() + message("a", 1)) + chunk(b"")
    assert texts(read(data)) == ["a"]
    assert texts(read(data + b"\x10")) == ["a"]


def test_a_chunk_that_claims_more_than_is_ever_read():
    """It takes no memory, and what comes after it is found."""
    good = chunk(SAID.encode() + message("a", 1))
    huge = chunk(message("b", 2), "lz4").replace(b"size=", b"SIZE=", 1)
    huge = huge.replace(b"SIZE=" + pack("<I", len(message("b", 2))), b"size=" + pack("<I", 0xFFFFFFF0))
    bag = read(HEAD + good + huge + chunk(message("c", 3)))
    assert texts(bag) == ["a", "c"]
    assert any("4294967280 bytes, at most" in line for line in bag.damage)


def test_an_index_record_that_is_cut_off():
    """By the end of the file, or because its count is wrong."""
    data = SAID.encode() + message("a", 1)
    whole = HEAD + chunk(data) + index([(1, len(SAID.encode()))])
    for cut in (1, 11, 12, 13, 30):
        assert texts(read(whole[:-cut])) == ["a"]


def test_a_chunk_of_a_compression_nobody_knows_is_passed_over():
    good = chunk(SAID.encode() + message("a", 1))
    odd = good.replace(b"compression=none", b"compression=zstd")
    bag = read(HEAD + good + odd + chunk(message("b", 2)))
    assert texts(bag) == ["a", "b"]
    assert any("zstd" in line for line in bag.damage)


def test_index_records_without_entries_say_nothing():
    data = SAID.encode() + message("a", 1)
    at = len(SAID.encode())
    bag = read(HEAD + chunk(data) + index([], 7) + index([(1, at)]) + chunk(message("b", 2)))
    assert texts(bag) == ["a", "b"]


def test_a_bag_that_ends_with_an_index_record():
    """Whether the index is complete cannot be told, so the chunk is read."""
    data = SAID.encode() + message("a", 1)
    bag = read(HEAD + chunk(data) + index([(1, len(SAID.encode()))]))
    assert texts(bag) == ["a"]


def test_a_file_header_that_is_another_record():
    other = encode_fields(
        {"op": b"\x09", "index_pos": bytes(8), "conn_count": bytes(4), "chunk_count": bytes(4)}
    )
    bag = read(MAGIC + other + pack("<I", 0) + chunk(SAID.encode() + message("a", 1)))
    assert texts(bag) == ["a"]
    assert "op 9 instead of a file header" in bag.damage[0]


def test_a_damaged_chunk_is_read_up_to_the_damage_in_a_scan():
    """A flipped length in the third message: the two before it are kept, and nothing behind it is trusted."""
    data = bytearray(SAID.encode() + message("a", 1) + message("b", 2) + message("c", 3))
    at = bytes(data).rindex(b"time=")
    data[at + 13 : at + 17] = pack("<I", 1 << 30)
    bag = read(HEAD + chunk(bytes(data)) + chunk(message("d", 4)), skip_damaged=True)
    assert texts(bag) == ["a", "b", "d"]
    assert bag.damage


def test_a_packed_chunk_of_garbage_is_left_out_of_a_scan():
    good = chunk(SAID.encode() + message("a", 1))
    bad = chunk(message("b", 2) * 50, "lz4")
    bad = bad[:60] + b"\xff" * (len(bad) - 60)
    bag = read(HEAD + good + bad + chunk(message("c", 3)), skip_damaged=True)
    assert texts(bag) == ["a", "c"]
    assert bag.damage


@pytest.mark.parametrize("name", ["bz2", "lz4"])
def test_a_prefix_of_a_stream_that_goes_on_behind_its_size(name):
    """The header's size is what may come out; a stream of more is not complete."""
    packed = compressor(name)(b"x" * 200_000)
    assert decompress_prefix(name, packed, 1000) == (b"x" * 1000, False)
    assert decompress_prefix(name, packed, 200_000) == (b"x" * 200_000, True)
    assert decompress_prefix(name, packed[:20], 200_000)[1] is False


@pytest.mark.parametrize("name", ["bz2", "lz4"])
@pytest.mark.parametrize("at", [0, 3, 5000, -6])
def test_a_prefix_of_a_damaged_stream_is_a_true_one(name, at):
    import random

    plain_bytes = random.Random(3).randbytes(1_000_000)
    packed = bytearray(compressor(name)(plain_bytes))
    packed[at] ^= 0xFF
    got, complete = decompress_prefix(name, bytes(packed), len(plain_bytes))
    assert not complete
    assert len(got) <= len(plain_bytes)
    if at == -6:  # at the very end: nearly everything comes before
        assert plain_bytes.startswith(got[:890_000])
        assert len(got) >= 890_000  # the first block of bz2


def test_a_sound_stream_in_small_steps_gives_all_of_it():
    import bz2

    packed = bz2.compress(b"y" * 100_000)
    assert _up_to_damage(bz2.BZ2Decompressor().decompress, packed, 100_000) == b"y" * 100_000
    assert _up_to_damage(bz2.BZ2Decompressor().decompress, packed, 10) == b"y" * 10


def test_without_the_lz4_package_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "lz4.frame", None)
    with pytest.raises(BagError, match="pip install lz4"):
        BagWriter(io.BytesIO(), "lz4")


def test_many_messages_of_one_topic_out_of_order_and_in_order():
    """More than are always sorted: looked at first."""
    for order in (list(range(400)), list(range(399, -1, -1)), [7] * 400):
        file = io.BytesIO()
        with BagWriter(file) as writer:
            for number, secs in enumerate(order):
                writer.write("/said", String(data=str(number)), secs)
        found = [(stamp.secs, int(m.data)) for _, m, stamp in BagReader(file).read_messages()]
        assert found == sorted((secs, number) for number, secs in enumerate(order))


def test_a_bag_that_changes_while_it_is_read(monkeypatch):
    """Overlapping chunks are read twice when memory is short; what was there may be gone."""
    from rosproto.bag import time_order

    monkeypatch.setattr(time_order, "BUDGET_BYTES", 1)
    stamps = [Time((i * 37) % 100, 0) for i in range(60)]
    file = io.BytesIO()
    with BagWriter(file, chunk_bytes=300) as writer:
        for number, stamp in enumerate(stamps):
            writer.write("/said", String(data=f"{number:060}"), stamp)
    bag = BagReader(file, skip_damaged=True)
    found = bag.read_messages()
    for _ in range(10):
        next(found)
    file.seek(len(HEAD))
    file.write(bytes(len(file.getvalue()) - len(HEAD)))
    with pytest.raises(BagError, match="changed while it was read"):
        list(found)


def test_what_they_are_called(tmp_path):
    path = tmp_path / "a.bag"
    with BagWriter(path, "lz4") as writer:
        assert repr(writer) == f"<BagWriter {path}: 0 messages, lz4>"
        writer.write("/said", String(), 1)
    with BagReader(path) as bag:
        assert repr(bag) == f"<BagReader {path}: 1 messages on 1 topics>"
        assert len(bag) == len(list(bag)) == 1
    assert repr(BagReader(io.BytesIO(HEAD))) == "<BagReader stream: 0 messages on 0 topics>"


def test_a_file_that_cannot_seek_is_told():
    class Pipe(io.RawIOBase):
        def seek(self, *_: object) -> int:
            raise OSError(29, "Illegal seek")

    with pytest.raises(BagError, match="cannot seek"):
        BagReader(Pipe())  # type: ignore[arg-type]


def test_reindex_where_nothing_can_be_written(tmp_path, monkeypatch):
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(entries(20), close=False))
    import builtins

    real = open

    def refuse(file: Any, mode: str = "r", *rest: Any, **more: Any) -> Any:
        if mode == "r+b":
            raise OSError(30, "Read-only file system")
        return real(file, mode, *rest, **more)

    monkeypatch.setattr(builtins, "open", refuse)
    with pytest.raises(BagError, match="cannot repair the bag: Read-only file system"):
        reindex(path)


def test_recover_tells_how_far_it_is(tmp_path):
    path, saved = tmp_path / "a.bag", tmp_path / "b.bag"
    with BagWriter(path) as writer:
        for i in range(20_001):
            writer.write("/said", String(), i)
    told: list[int] = []
    assert recover(path, saved, progress=told.append).messages == 20_001
    assert told == list(range(100, 20_001, 100))
    with pytest.raises(BagError, match="already exists"):
        recover(path, saved)


def test_definitions_that_are_no_use():
    """Neither bundled under that name nor readable as stored; an older bundled revision by its md5sum."""
    with pytest.raises(BagError, match="no usable definition of no_such/Thing"):
        message_class_of(Connection(0, "/x", "no_such/Thing", "0" * 32, "float32 [ nonsense"))
    with pytest.raises(BagError, match="no usable definition"):
        message_class_of(Connection(0, "/x", "no_such/Thing", "0" * 32, ""))
    with pytest.raises(BagError, match="no usable definition"):
        message_class_of(Connection(0, "/x", "not a name", "0" * 32, ""))


def test_a_revision_that_is_not_bundled_is_read_by_its_own_text():
    """Of a type of which other revisions are bundled."""
    kind, _ = a_revision()
    text = "int32 of_this_robot_only\n"
    found = message_class_of(Connection(0, "/x", kind, "0" * 32, text))
    assert found.__slots__ == ["of_this_robot_only"] or tuple(found.__slots__) == ("of_this_robot_only",)


def test_an_older_bundled_revision_is_known_by_its_md5sum():
    kind, md5sum = a_revision()
    found = message_class_of(Connection(0, "/x", kind, md5sum, ""))
    assert (found._type, found._md5sum) == (kind, md5sum)


def a_revision() -> tuple[str, str]:
    """A bundled type that has other revisions, and the md5sum of one of these."""
    from rosproto.msg import bundled

    library = bundled()
    for package in library.packages():
        for name in library.messages(package):
            kind = f"{package}/{name.rpartition('/')[2]}"
            for revision in library.revisions(kind):
                if revision.md5sum != library.md5sum(kind):
                    return kind, revision.md5sum
    raise AssertionError("no type has revisions")


def test_walking_tolerates_damage_only_where_asked():
    data = SAID.encode() + message("a", 1) + b"\xff\xff"
    offsets, connections = walk(data, 0, len(data), tolerant=True)
    assert (len(offsets), len(connections)) == (1, 1)
    with pytest.raises(BagError, match="ends inside"):
        walk(data, 0, len(data))
    partial = ChunkData(ChunkInfo(0, 0, 0), data, 0, len(data), complete=False)
    assert len(partial.rows().conn) == 1


@pytest.mark.parametrize("step", [1000])
@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_cut_at_every_thousandth_byte_and_mended(tmp_path: Path, compression, step):
    """Reading gives a prefix, reindex makes a sound bag of it, and the same messages are in it."""
    what = entries(250)
    data = bag_bytes(what, compression, 3000)
    expected = encoded(what)
    path = tmp_path / "cut.bag"
    for cut in range(len(HEAD), len(data), step):
        found = plain(read(data[:cut]).read_messages(raw=True))
        assert found == expected[: len(found)]
        path.write_bytes(data[:cut])
        reindex(path)
        with BagReader(path) as bag:
            assert bag.damage == []
            assert plain(bag.read_messages(raw=True)) == found


def test_message_records_with_more_fields_than_usual():
    """Beside usual ones: where things are in a header is looked up each time."""
    fields = {"op": b"\x02", "conn": pack("<I", 0), "time": pack("<II", 2, 0), "note": b"x"}
    data = SAID.encode() + message("a", 1) + encode_record(fields, encode(String(data="b"))) + message("c", 3)
    bag = read(HEAD + chunk(data))
    assert texts(bag) == ["a", "b", "c"]
    only = read(HEAD + chunk(SAID.encode() + encode_record(fields, encode(String(data="b")))))
    assert texts(only) == ["b"]


def test_times_without_index_records_come_from_the_messages():
    bag = read(HEAD + chunk(SAID.encode() + message("a", 5) + message("b", 2)))
    assert bag.times("/said").tolist() == [2 * 10**9, 5 * 10**9]
    assert texts(bag) == texts(bag) == ["b", "a"]


def test_overlapping_chunks_decoded_and_the_times_of_a_topic_that_is_in_one_of_them():
    """Two messages in a row may come from the same chunk, or not."""
    rare = Connection(1, "/rare", "std_msgs/String", String._md5sum, String._full_text)
    first = SAID.encode() + message("a", 1) + message("b", 2) + message("d", 4)
    second = rare.encode() + message("c", 3, pack("<I", 1)) + message("e", 5) + message("f", 6)
    chunks = [chunk(first), chunk(second)]
    bag = read(HEAD + b"".join(chunks))
    assert texts(bag) == ["a", "b", "c", "d", "e", "f"]
    assert bag.times("/rare").tolist() == [3 * 10**9]
