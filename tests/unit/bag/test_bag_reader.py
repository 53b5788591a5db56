"""Reading sound bags: order, filters, definitions, table of contents."""

from __future__ import annotations

import io
import math
import threading
from datetime import datetime
from struct import pack

import numpy as np
import pytest

from rosproto.bag import BagReader, BagWriter, Connection, reader, reindex, time_order
from rosproto.bag.bag_file import BagFile
from rosproto.bag.records import MAGIC, FileHeader, encode_fields
from rosproto.codec import define, encode, message_class
from rosproto.errors import BagError
from rosproto.time import Time
from tests.unit.bag.bagmaker import COMPRESSIONS, String, Twist, bag_bytes, encoded, entries, plain, read


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_messages_come_back_decoded_and_raw(compression):
    what = entries(200)
    bag = read(bag_bytes(what, compression))
    assert bag.damage == []
    assert bag.indexed
    assert [(t, encode(m), s) for t, m, s in bag] == encoded(what)
    assert plain(bag.read_messages(raw=True)) == encoded(what)
    assert bag.compression()[compression].chunks == len(bag.chunks) > 5


def test_the_table_of_contents():
    bag = read(bag_bytes(entries(50)))
    assert list(bag.topics) == ["/chatter", "/cmd_vel", "/data"]
    assert bag.topics["/chatter"].types == ("std_msgs/String",)
    assert {t: i.message_count for t, i in bag.topics.items()} == {
        "/chatter": 20,
        "/cmd_vel": 20,
        "/data": 10,
    }
    assert len(bag) == bag.message_count == 50
    assert (bag.start_time, bag.end_time) == (Time(100), Time(104, 900_000_000))
    assert bag.duration == pytest.approx(4.9)


def test_an_empty_bag():
    bag = read(bag_bytes([]))
    assert (bag.message_count, bag.start_time, bag.end_time, bag.duration) == (0, None, None, 0.0)
    assert list(bag) == []
    assert bag.damage == []


@pytest.mark.parametrize("topics", ["/chatter", ["/chatter", "/data"], [], {"/nowhere"}])
def test_only_some_topics(topics):
    what = entries(100)
    names = [topics] if isinstance(topics, str) else topics
    expected = [e for e in encoded(what) if e[0] in names]
    assert plain(read(bag_bytes(what)).read_messages(topics, raw=True)) == expected


@pytest.mark.parametrize(
    ("start", "end"), [(None, 103.0), (103.0, None), (Time(102), Time(103)), (200, 300), (5, 4)]
)
def test_a_span_of_time_includes_both_ends(start, end):
    what = entries(100)

    def within(stamp):
        low = start is None or stamp.to_sec() >= (
            start if isinstance(start, (int, float)) else start.to_sec()
        )
        return low and (
            end is None or stamp.to_sec() <= (end if isinstance(end, (int, float)) else end.to_sec())
        )

    expected = [e for e in encoded(what) if within(e[2])]
    assert plain(read(bag_bytes(what)).read_messages(None, start, end, raw=True)) == expected


@pytest.mark.promise("Neither the messages in a chunk nor the chunks are ordered")
def test_messages_written_out_of_order_come_in_the_order_of_time():
    what = entries(300)
    shuffled = [what[i * 97 % 300] for i in range(300)]
    bag = read(bag_bytes(shuffled))
    assert plain(bag.read_messages(raw=True)) == encoded(what)
    assert [(t, encode(m), s) for t, m, s in bag] == encoded(what)


def test_more_overlapping_chunks_than_the_memory_budget(monkeypatch):
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 4000)
    what = entries(300)
    bag = read(bag_bytes([what[i * 97 % 300] for i in range(300)], "lz4"))
    assert plain(bag.read_messages(raw=True)) == encoded(what)


@pytest.mark.promise(
    "are merged in 64 MB of memory for chunks", "they are read again for each 64 MB of messages at most"
)
@pytest.mark.parametrize("chunk_bytes", [700, 3000])
def test_chunks_that_all_overlap_are_read_a_few_times(monkeypatch, chunk_bytes):
    """Not once for each message: a small lz4 bag would take hours. Messages and their positions are the same."""
    what = entries(2000)
    made = bag_bytes([what[i * 97 % 2000] for i in range(2000)], "lz4", chunk_bytes=chunk_bytes)
    expected = [(topic, message, stamp) for topic, message, stamp in read(made).read_messages(raw=True)]
    reads = []
    real = reader.read_chunk
    monkeypatch.setattr(reader, "read_chunk", lambda *args, **more: reads.append(args) or real(*args, **more))
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 100_000)
    bag = read(made)
    assert list(bag.read_messages(raw=True)) == expected
    taken = sum(len(message.data) + time_order.MESSAGE_BYTES for _, message, _ in expected)
    assert len(reads) <= len(bag.chunks) * (taken / 100_000 + 2)


def test_chunks_that_are_still_in_memory_are_not_read_again(monkeypatch):
    """A pass takes them first; those it unpacks are unpacked beside the reader, as in the first pass."""
    what = entries(2000)
    made = bag_bytes([what[i * 97 % 2000] for i in range(2000)], "lz4", chunk_bytes=3000)
    expected = plain(read(made).read_messages(raw=True))
    reads, threads = [], set()
    real = reader.read_chunk

    def read_chunk(source, info, *given, **more):
        reads.append(info.pos)
        if len(reads) > len(bag.chunks) + 20:
            threads.add(threading.current_thread().name)
        return real(source, info, *given, **more)

    monkeypatch.setattr(reader, "read_chunk", read_chunk)
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 100_000)
    bag = read(made)
    assert plain(bag.read_messages(raw=True)) == expected
    size = sum(len(data) for _, data, _ in expected)
    passes = -(-(size + time_order.MESSAGE_BYTES * 2000) // 100_000)
    assert passes >= 3
    assert len(reads) <= len(bag.chunks) * (1 + passes / 2)
    assert any("bag reader" in name for name in threads)


@pytest.mark.promise("are merged in 64 MB of memory for chunks")
@pytest.mark.parametrize("budget", [40_000, 250_000])
def test_chunks_of_bz2_are_kept_as_lz4_and_unpacked_less_often(monkeypatch, budget):
    """Unpacking bz2 is what such a bag costs; the memory for chunks is the same."""
    what = [("/a", String(data=f"{n} " * 100), Time(n + 1)) for n in range(2000)]
    made = bag_bytes([what[i * 97 % 2000] for i in range(2000)], "bz2", chunk_bytes=3000)
    monkeypatch.setattr(time_order, "BUDGET_BYTES", budget)
    reads, held = [], []
    real, get = reader.read_chunk, time_order.ChunkCache.get
    monkeypatch.setattr(reader, "read_chunk", lambda *args, **more: reads.append(args) or real(*args, **more))

    def noted(cache, *args):
        data = get(cache, *args)
        held.append(cache.held_bytes)
        return data

    monkeypatch.setattr(time_order.ChunkCache, "get", noted)
    bag = read(made)
    assert plain(bag.read_messages(raw=True)) == encoded(what)
    passes = 1 + sum(len(data) + time_order.MESSAGE_BYTES for _, data, _ in encoded(what)) // budget
    assert passes >= 4
    assert max(held) <= budget
    if budget == 250_000:  # all of them fit as LZ4
        assert len(reads) <= len(bag.chunks) + 2 * passes
    else:
        assert len(reads) <= len(bag.chunks) * passes


@pytest.mark.promise("at most, or for as many as the largest chunk has")
def test_overlapping_chunks_larger_than_the_budget_are_read_once_for_as_many_messages(monkeypatch):
    """Four chunks of 275 MB took two minutes."""
    what = entries(2000)
    made = bag_bytes([what[i * 97 % 2000] for i in range(2000)], "lz4", chunk_bytes=60_000)
    reads, sizes = [], set()
    real = reader.read_chunk

    def read_chunk(*given, **more):
        chunk = real(*given, **more)
        reads.append(chunk.info.pos)
        sizes.add(len(chunk.blob))
        return chunk

    monkeypatch.setattr(reader, "read_chunk", read_chunk)
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 1000)
    bag = read(made)
    messages = [message for _, message, _ in bag.read_messages(raw=True)]
    assert len(messages) == 2000
    taken = sum(len(message.data) + time_order.MESSAGE_BYTES for message in messages)
    assert len(bag.chunks) > 2
    assert len(reads) <= len(bag.chunks) * (taken / max(sizes) + 2)


def test_messages_kept_of_chunks_that_do_not_fit_need_no_second_reading(monkeypatch):
    """One topic of several in chunks that all overlap: what is wanted of them fits into memory."""
    what = [(f"/{n % 8}", String(data=f"{n} " * 100), Time(n + 1)) for n in range(2000)]
    made = bag_bytes([what[i * 97 % 2000] for i in range(2000)], "lz4", chunk_bytes=6000)
    reads = []
    real = reader.read_chunk
    monkeypatch.setattr(reader, "read_chunk", lambda *args, **more: reads.append(args) or real(*args, **more))
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 200_000)
    bag = read(made)
    assert plain(bag.read_messages("/3", raw=True)) == encoded([entry for entry in what if entry[0] == "/3"])
    assert len(reads) <= len(bag.chunks)


def shuffled_pictures() -> tuple[list[tuple[str, String, Time]], bytes]:
    """Messages of 5 kB in no order of time, uncompressed, and their bag."""
    what = [("/a", String(data=f"{n} " * 1500), Time(n + 1)) for n in range(200)]
    return what, bag_bytes([what[i * 97 % 200] for i in range(200)], chunk_bytes=40_000)


@pytest.mark.parametrize("raw", [True, "view"])
def test_large_messages_of_uncompressed_chunks_that_overlap_are_read_once(monkeypatch, raw):
    what, made = shuffled_pictures()
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 100_000)
    sizes = []
    real = BagFile.read_at
    bag = read(made)
    monkeypatch.setattr(BagFile, "read_at", lambda *args: sizes.append(args[2]) or real(*args))
    found = list(bag.read_messages(raw=raw))
    assert plain(found) == encoded(what)
    assert sum(sizes) < 1.1 * len(made)
    assert [bag.message_from(m.position)[1].data for _, m, _ in found[:20]] == [
        m.data for _, m, _ in found[:20]
    ]


def test_a_bag_that_is_cut_while_its_messages_are_read_one_by_one(monkeypatch):
    _, made = shuffled_pictures()
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 100_000)
    file = io.BytesIO(made)
    messages = BagReader(file).read_messages(raw=True)
    next(messages)
    file.truncate(50_000)
    with pytest.raises(BagError, match=r"changed|cannot be read"):
        list(messages)


def test_a_bag_that_is_closed_while_its_messages_are_read_one_by_one(monkeypatch, tmp_path):
    what, made = shuffled_pictures()
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 100_000)
    (tmp_path / "a.bag").write_bytes(made)
    with BagReader(tmp_path / "a.bag") as bag:
        messages = bag.read_messages(raw=True)
        assert next(messages)[1].data == encoded(what)[0][1]
    with pytest.raises(BagError, match="closed"):
        list(messages)


def test_equal_times_keep_the_order_of_the_file():
    what = [("/chatter", String(data=str(i)), Time(5)) for i in range(500)]
    bag = read(bag_bytes(what, chunk_bytes=700))
    assert [m.data for _, m, _ in bag] == [str(i) for i in range(500)]


def test_times_are_kept_as_recorded():
    stamps = [Time.from_wire(0, 0), Time.from_wire(1, 999_999_999), Time.from_wire(4294967295, 999_999_999)]
    what = [("/chatter", String(data="x"), s) for s in stamps]
    found = [s for _, _, s in read(bag_bytes(what))]
    assert [(s.secs, s.nsecs) for s in found] == [(s.secs, s.nsecs) for s in stamps]


def test_several_definitions_of_one_type_and_several_connections_on_one_topic():
    old = define("my_msgs/Value", "int32 x")
    new = define("my_msgs/Value", "int32 x\nstring name")
    what = [("/v", old(x=1), Time(1)), ("/v", new(x=2, name="two"), Time(2)), ("/v", old(x=3), Time(3))]
    bag = read(bag_bytes(what))
    assert len(bag.topics["/v"].connections) == 2
    assert [(m.x, getattr(m, "name", None)) for _, m, _ in bag] == [(1, None), (2, "two"), (3, None)]
    first = bag.topics["/v"].connections[0]
    assert [m.x for _, m, _ in bag.read_messages(connections=[first])] == [1, 3]


def test_a_missing_definition_gives_way_to_the_bundled_one_of_that_md5sum():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        careless = Connection(0, "/cmd", "geometry_msgs/Twist", Twist._md5sum, "")
        writer.write_raw(careless, encode(Twist()), Time(1))
    assert [m for _, m, _ in read(file.getvalue())] == [Twist()]


def test_without_any_usable_definition_raw_still_works():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write_raw(Connection(0, "/x", "no_msgs/Such", "0" * 32, ""), b"abc", Time(1))
    bag = read(file.getvalue())
    with pytest.raises(BagError, match="copied and played, not decoded"):
        list(bag)
    assert [m.data for _, m, _ in bag.read_messages(raw=True)] == [b"abc"]


def test_decoded_arrays_are_read_only_and_small_messages_do_not_hold_their_chunk():
    what = entries(200)
    arrays = [
        m.data for _, m, _ in read(bag_bytes(what, chunk_bytes=100_000)).read_messages("/data") if len(m.data)
    ]
    assert all(not a.flags.writeable for a in arrays)
    owner = arrays[-1]
    while isinstance(owner, np.ndarray):
        owner = owner.base
    assert len(owner) < 1000


def test_the_latest_message_at_a_time():
    bag = read(bag_bytes(entries(100), "lz4"))
    topic, message, stamp = bag.message_at("/chatter", 105.15)
    assert (topic, message.data, stamp) == ("/chatter", "hello 51", Time(105, 100_000_000))
    assert bag.message_at("/chatter", Time(100, 100_000_000))[1].data == "hello 1"
    assert bag.message_at("/chatter", 100.05) is None
    assert bag.message_at("/chatter", 1e6, raw=True)[1].type == "std_msgs/String"


def test_the_latest_message_at_a_time_in_an_unordered_bag():
    what = entries(300)
    bag = read(bag_bytes([what[i * 97 % 300] for i in range(300)]))
    for at in (101.0, 110.35, 129.9):
        expected = [e for e in what if e[0] == "/chatter" and e[2].to_sec() <= at][-1]
        assert bag.message_at("/chatter", at)[1] == expected[1]


def test_times_and_frequency_come_from_the_index():
    bag = read(bag_bytes([("/c", String(data="x"), i * 0.25 + 10) for i in range(50)]))
    assert bag.times("/c").tolist() == [10_000_000_000 + i * 250_000_000 for i in range(50)]
    assert bag.frequency("/c") == pytest.approx(4.0)
    assert read(bag_bytes([("/c", String(), 1.0)])).frequency("/c") is None


def test_columns():
    columns = read(bag_bytes(entries(100))).to_numpy("/cmd_vel", ["linear.x", "angular.z"])
    assert columns["linear.x"].dtype == np.float64
    assert columns["linear.x"].tolist() == [float(i) for i in range(0, 100, 2) if i % 5 != 4]
    assert columns["receive_time"][:3].tolist() == [100.0, 100.2, 100.6]
    assert not columns["angular.z"].any()


def test_columns_of_arrays_times_and_texts():
    Odd = define("my_msgs/Odd", "time at\nint16[3] fixed\nint16[] free\nstring name")
    what = [
        ("/o", Odd(at=Time(i, 500_000_000), fixed=[i, 2, 3], free=[1] * i, name=str(i)), i) for i in range(3)
    ]
    columns = read(bag_bytes(what)).to_numpy("/o", ["at", "fixed", "free", "name"])
    assert columns["at"].tolist() == [0.5, 1.5, 2.5]
    assert columns["fixed"].shape == (3, 3)
    assert [len(v) for v in columns["free"]] == [0, 1, 2]
    assert columns["name"].tolist() == ["0", "1", "2"]


def test_an_unknown_field_or_topic_is_told_with_what_there_is():
    bag = read(bag_bytes(entries(10)))
    with pytest.raises(BagError, match=r"no field 'linear\.w'.*x, y, z"):
        bag.to_numpy("/cmd_vel", ["linear.w"])
    with pytest.raises(BagError, match="/chatter, /cmd_vel, /data"):
        bag.to_numpy("/nowhere", ["data"])


def test_two_iterations_at_once_do_not_disturb_each_other():
    bag = read(bag_bytes(entries(100), "lz4"))
    one, two = bag.read_messages("/chatter"), bag.read_messages("/cmd_vel")
    pairs = [(next(one)[1].data, next(two)[1].linear.x) for _ in range(30)]
    assert pairs[0] == ("hello 1", 0.0)
    assert pairs[29][0] == "hello 73"


def test_an_index_that_lies_is_noticed_and_the_records_are_followed():
    data = bag_bytes([("/c", String(data=str(i)), i) for i in range(20)], chunk_bytes=100_000)
    at = data.index(b"op=\x04")
    entry = data.index(pack("<III", 7, 0, 0)[:8], at) + 8  # the offset of the message of second 7
    lying = data[:entry] + pack("<I", 5) + data[entry + 4 :]
    assert [m.data for _, m, _ in read(lying)] == [str(i) for i in range(20)]


def test_python_rosbags_field_order_and_mixed_orders_are_read():
    data = bag_bytes([("/c", String(data=str(i)), i) for i in range(20)], chunk_bytes=100_000)
    ours = b"\x09\0\0\0conn=" + bytes(4) + b"\x04\0\0\0op=\x02"
    theirs = b"\x04\0\0\0op=\x02" + b"\x09\0\0\0conn=" + bytes(4)
    assert data.count(ours) == 20
    for count in (20, 7):
        assert [m.data for _, m, _ in read(data.replace(ours, theirs, count))] == [str(i) for i in range(20)]


def test_a_file_is_opened_and_closed(tmp_path):
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(entries(10)))
    with BagReader(path) as bag:
        assert bag.path == str(path)
        assert len(list(bag)) == 10
    for closed in (bag, BagReader(path, skip_damaged=True)):
        closed.close()
        with pytest.raises(BagError, match="the bag is closed"):
            list(closed)
    with path.open() as text, pytest.raises(BagError, match='"rb"'):
        BagReader(text)


@pytest.mark.parametrize("start", ["now", math.nan, datetime(2026, 1, 1)])
def test_what_is_no_time_is_refused_with_what_is_expected(start):
    with pytest.raises(ValueError, match=r"time .*since 1970"):
        list(read(bag_bytes(entries(1))).read_messages(start_time=start))


def test_a_disk_that_fails_in_the_middle_costs_the_messages_there():
    """EIO, as dying memory cards give it: an error with the place, or the chunk is left out and told."""

    class Card(io.BytesIO):
        broken = range(0)

        def read(self, size: int | None = -1) -> bytes:
            if self.tell() in self.broken:
                raise OSError(5, "Input/output error")
            return super().read(size)

    card = Card(bag_bytes(entries(100), chunk_bytes=200))
    with BagReader(card, skip_damaged=True) as bag:
        chunks = bag.chunks
        card.broken = range(chunks[3].pos, chunks[4].pos)
        assert len(list(bag)) == 100 - sum(chunks[3].counts.values())
        assert "Input/output error" in bag.damage[0]
    with pytest.raises(BagError, match=r"cannot be read: Input/output error.*skip_damaged"):
        list(BagReader(card))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"#ROSB", "inside the version line"),
        (b"not a bag at all", "not a bag.*expected b'#ROSBAG V2.0'$"),
        (b"PK\x03\x04...", "not a bag.*ZIP.*unpack"),
        (b"\x89MCAP0\r\n...", "not a bag.*MCAP"),
        (b"version https://git-lfs.github.com/spec/v1\n", "not a bag.*git lfs pull"),
        (b"#ROSBAG V1.2\n", "version 1.2.*only 2.x.*rosbag fix"),
        (b"#ROSRECORD V1.1\n", "version 1.1.*only 2.x"),
        (b"#ROSBAG V3.0\n", "version 3.0.*only 2.x is read$"),
    ],
)
def test_what_is_no_bag_of_version_2_is_refused_by_name(data, words):
    with pytest.raises(BagError, match=words):
        read(data)


@pytest.mark.parametrize("version", ["2.0", "2.1", "2.9", "2.10"])
def test_any_version_2_is_read(version, tmp_path):
    """As rosbag reads it; appending, mending and copying go by where the header really begins."""
    path = tmp_path / "other.bag"
    what = entries(30)
    for close in (True, False):
        data = bag_bytes(what, close=close).replace(b"V2.0", b"V" + version.encode(), 1)
        path.write_bytes(data)
        with BagReader(path) as bag:
            assert bag.version == version
            before = plain(bag.read_messages(raw=True))
            assert before == encoded(what)[: len(before)] != []
            assert bag.indexed is (close and len(version) == 3)
        reindex(path)
        with BagWriter(path, append=True) as writer:
            writer.write("/chatter", String(data="more"), Time(500))
        with BagReader(path) as bag:
            assert (bag.version, bag.indexed, bag.damage) == (version, True, [])
            assert plain(bag.read_messages(raw=True))[:-1] == before


def test_a_version_line_that_is_cut_off_behind_its_number():
    bag = read(MAGIC[:-1])
    assert (bag.message_count, bag.indexed) == (0, False)
    assert "file header" in bag.damage[0]


def test_an_encrypted_bag_is_refused_by_name():
    fields = {"op": b"\x03", "index_pos": bytes(8), "conn_count": bytes(4), "chunk_count": bytes(4)}
    head = encode_fields(fields | {"encryptor": b"rosbag/AesCbcEncryptor"})
    with pytest.raises(BagError, match="encrypted with rosbag/AesCbcEncryptor"):
        read(MAGIC + head + pack("<I", 0) + FileHeader().encode())


def test_a_missing_file_is_a_bag_error(tmp_path):
    with pytest.raises(BagError, match="cannot open"):
        BagReader(tmp_path / "none.bag")


def test_message_classes_of_known_types_are_the_bundled_ones():
    bag = read(bag_bytes(entries(10)))
    assert bag.message_class("/cmd_vel") is message_class("geometry_msgs/Twist")


@pytest.mark.parametrize("count", [3, 600])
def test_nanoseconds_beyond_a_second_are_carried_over_as_by_rosbag(tmp_path, count):
    """A damaged or odd file may hold them; where a bag cannot store the seconds, the time stays as recorded."""
    path = tmp_path / "odd.bag"
    with BagWriter(path) as writer:
        for i in range(count):
            writer.write("/n", String(data=str(i)), Time.from_wire(10 + i, 2_500_000_000))
        writer.write("/n", String(data="last"), Time.from_wire(0xFFFFFFFF, 1_000_000_007))
    with BagReader(path) as bag:
        expected = [(12 + i, 500_000_000) for i in range(count)] + [(0xFFFFFFFF, 1_000_000_007)]
        for raw in (False, True):
            assert [(t.secs, t.nsecs) for _, _, t in bag.read_messages(raw=raw)] == expected
        _, message, at = bag.message_at("/n", 13.0)
        assert (message.data, at.secs, at.nsecs) == ("0", 12, 500_000_000)
