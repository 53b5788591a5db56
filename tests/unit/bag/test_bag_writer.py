"""Writing bags: what is refused, what is shared, what a failure leaves behind."""

from __future__ import annotations

import errno
import io
import math
from datetime import datetime

import numpy as np
import pytest

from rosproto.bag import BagReader, BagWriter, RawMessage
from rosproto.codec import AnyMsg, encode, message_class
from rosproto.errors import BagError, CodecError
from rosproto.time import Time
from tests.unit.bag.bagmaker import COMPRESSIONS, String, Twist, bag_bytes, encoded, entries, plain, read

Image = message_class("sensor_msgs/Image")


@pytest.mark.parametrize("first", COMPRESSIONS)
@pytest.mark.parametrize("second", COMPRESSIONS)
def test_append_continues_a_bag_with_its_connections(first, second):
    what = entries(60)
    file = io.BytesIO(bag_bytes(what[:30], first))
    with BagWriter(file, second, 1500, append=True) as writer:
        for topic, message, stamp in what[30:]:
            writer.write(topic, message, stamp)
    bag = read(file.getvalue())
    assert bag.damage == []
    assert len(bag.connections) == 3
    assert plain(bag.read_messages(raw=True)) == encoded(what)


def test_append_to_nothing_starts_a_bag(tmp_path):
    path = tmp_path / "new.bag"
    for number in (1, 2):
        with BagWriter(path, append=True) as writer:
            writer.write("/c", String(data=str(number)), number)
    with BagReader(path) as bag:
        assert [m.data for _, m, _ in bag] == ["1", "2"]


def test_a_bag_without_index_cannot_be_continued_before_it_is_mended():
    file = io.BytesIO(bag_bytes(entries(30), close=False))
    with pytest.raises(BagError, match="reindex"):
        BagWriter(file, append=True)


def test_one_connection_for_each_topic_type_and_header():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        for caller in ("/a", "/b", "/a"):
            writer.write("/c", String(data=caller), 1, header={"callerid": caller, "latching": "1"})
        writer.write("/c", String(data="-"), 1)
        writer.write("/d", String(data="-"), 1)
        writer.write("/c", Twist(), 1)
    connections = read(file.getvalue()).connections.values()
    found = [(c.topic, c.type, c.callerid, c.latching) for c in connections]
    assert found == [
        ("/c", "std_msgs/String", "/a", True),
        ("/c", "std_msgs/String", "/b", True),
        ("/c", "std_msgs/String", "", False),
        ("/d", "std_msgs/String", "", False),
        ("/c", "geometry_msgs/Twist", "", False),
    ]


def test_a_raw_message_takes_its_connection_along_also_to_another_topic():
    bag = read(bag_bytes(entries(10)))
    file = io.BytesIO()
    with BagWriter(file) as writer:
        for topic, raw, stamp in bag.read_messages(raw=True):
            writer.write("/copy" + topic, raw, stamp)
    again = read(file.getvalue())
    assert [(t, encode(m)) for t, m, _ in again] == [("/copy" + t, d) for t, d, _ in encoded(entries(10))]
    assert again.connections[0].header["topic"] == bag.connections[0].topic


def test_raw_and_decoded_messages_of_one_definition_share_a_connection():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write("/c", String(data="one"), 1)
        (connection,) = [
            c
            for _, r, _ in read(bag_bytes([("/c", String(), 1)])).read_messages(raw=True)
            for c in [r.connection]
        ]
        writer.write(
            "/c", RawMessage("std_msgs/String", encode(String(data="two")), "", (0, 0), connection), 2
        )
        writer.write("/c", String(data="three"), 3)
    bag = read(file.getvalue())
    assert [m.data for _, m, _ in bag] == ["one", "two", "three"]
    assert len(bag.connections) == 1


def test_a_message_received_undecoded_is_stored_with_its_publishers_definition():
    raw = AnyMsg()
    raw._buff = encode(String(data="x"))
    raw._connection_header = {
        "type": "std_msgs/String", "md5sum": String._md5sum, "message_definition": String._full_text, "callerid": "/p",
    }  # fmt: skip
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write("/c", raw, 1)
        with pytest.raises(ValueError, match="no type"):
            writer.write("/c", AnyMsg(), 1)
    bag = read(file.getvalue())
    assert [m.data for _, m, _ in bag] == ["x"]
    assert bag.connections[0].callerid == "/p"


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("chunk_bytes", [1000, 10_000_000])
def test_changing_a_large_message_after_write_changes_nothing(compression, chunk_bytes):
    file = io.BytesIO()
    pixels = np.zeros(300_000, np.uint8)
    image = Image(data=pixels, height=3)
    with BagWriter(file, compression, chunk_bytes) as writer:
        for number in range(4):
            pixels[:] = number
            writer.write("/i", image, number)
        pixels[:] = 99
    found = [m.data for _, m, _ in read(file.getvalue())]
    assert [(len(d), int(d.min()), int(d.max())) for d in found] == [(300_000, n, n) for n in range(4)]


def test_a_message_that_does_not_encode_leaves_no_trace():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        with pytest.raises(CodecError):
            writer.write("/bad", String(data=5), 1)
        writer.write("/good", String(data="x"), 1)
    bag = read(file.getvalue())
    assert list(bag.connections) == [0]
    assert [t for t, _, _ in bag] == ["/good"]


@pytest.mark.parametrize("t", [-1.0, 2.0**32, Time.from_wire(-1, 0)])
def test_a_time_that_does_not_fit_is_refused(t):
    file = io.BytesIO()
    with BagWriter(file) as writer, pytest.raises(ValueError, match="unsigned 32-bit"):
        writer.write("/c", String(data="x"), t)
    assert read(file.getvalue()).message_count == 0


@pytest.mark.parametrize("t", [np.float64(5.0), np.int64(5), np.float32(5.0), 5])
def test_any_number_is_a_time_in_seconds(t):
    assert [stamp.to_nsec() for _, _, stamp in read(bag_bytes([("/a", String(), t)]))] == [5 * 10**9]


@pytest.mark.parametrize(
    ("t", "words"),
    [
        (math.nan, "time nan"),
        (math.inf, "time inf"),
        (datetime(2026, 1, 1), "not datetime"),
        ("now", "not str"),
        (1_700_000_000_123_456_789, "not nanoseconds"),
    ],
)
def test_what_is_no_time_is_refused_and_adds_nothing(t, words):
    file = io.BytesIO()
    with BagWriter(file) as bag, pytest.raises(ValueError, match=words):
        bag.write("/a", String(), t)
    assert read(file.getvalue()).message_count == 0


@pytest.mark.parametrize("message", [None, {"data": "x"}, String, b"123", object()])
def test_what_is_no_message_is_refused_with_what_is_expected(message):
    with BagWriter(io.BytesIO()) as bag, pytest.raises(TypeError, match=r"/a: a message .* is expected, not"):
        bag.write("/a", message, 1)


@pytest.mark.parametrize("header", [{"callerid": 5}, {"callerid": b"/x"}, {"a=b": "c"}, {1: "x"}])
def test_a_header_that_cannot_be_stored_leaves_the_bag_sound(header):
    """Once it was found with the first message only, and then at the end: the table of contents was lost."""
    file = io.BytesIO()
    with BagWriter(file) as bag:
        bag.write("/a", String(data="x"), 1)
        with pytest.raises(ValueError, match=r"header .*texts are expected"):
            bag.write("/b", String(data="y"), 2, header=header)
    assert [(topic, m.data) for topic, m, _ in read(file.getvalue())] == [("/a", "x")]


def test_seconds_are_stored_to_the_nanosecond():
    assert [s for _, _, s in read(bag_bytes([("/c", String(), 1.25)]))] == [Time(1, 250_000_000)]


def test_without_a_time_it_is_now():
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write("/c", String())
    (stamp,) = [s for _, _, s in read(file.getvalue())]
    assert stamp.secs > 1_600_000_000


def test_a_closed_bag_takes_nothing_more():
    file = io.BytesIO()
    writer = BagWriter(file)
    writer.write("/c", String(), 1)
    writer.close()
    writer.close()
    for topic in ("/c", "/new"):
        with pytest.raises(BagError, match="closed"):
            writer.write(topic, String(), 1)
    with pytest.raises(BagError, match="closed"):
        writer.flush()
    assert read(file.getvalue()).message_count == 1


def test_flush_makes_what_was_written_readable(tmp_path):
    path = tmp_path / "a.bag"
    with BagWriter(path) as writer:
        writer.write("/c", String(data="x"), 1)
        assert BagReader(path).message_count == 0
        writer.flush()
        with BagReader(path) as bag:
            assert [m.data for _, m, _ in bag] == ["x"]


class FullDisk(io.BytesIO):
    """A file on a disk with so much room."""

    room = 20_000

    def write(self, data):
        if self.tell() + len(data) > self.room:
            half = max(self.room - self.tell(), 0)
            super().write(data[:half])
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_full_disk_is_an_error_and_leaves_whole_chunks(compression):
    what = entries(4000)
    file = FullDisk()
    writer = BagWriter(file, compression, 4000)

    def write_all():
        for i, (topic, message, stamp) in enumerate(what):
            writer.write(topic, message, stamp)
            if i % 100 == 99:
                writer.flush()  # waits for the compressed chunks

    with pytest.raises(BagError, match="No space left") as caught:
        write_all()
    assert f"readable up to byte {caught.value.offset}" in str(caught.value)
    with pytest.raises(BagError, match="No space left"):
        writer.write("/chatter", String(), 1)
    try:
        writer.close()
    except BagError:
        pass  # the table of contents does not fit either; the bag is an unclosed one then
    found = plain(read(file.getvalue()).read_messages(raw=True))
    assert found == encoded(what)[: len(found)]
    assert 0 < len(found) <= writer.message_count < 4000


def test_unknown_compression_and_senseless_chunk_sizes_are_refused():
    with pytest.raises(ValueError, match="none, bz2, lz4"):
        BagWriter(io.BytesIO(), "zip")
    with pytest.raises(ValueError, match="chunk_bytes"):
        BagWriter(io.BytesIO(), chunk_bytes=0)


def test_a_path_that_cannot_be_opened_is_a_bag_error(tmp_path):
    with pytest.raises(BagError, match="cannot open"):
        BagWriter(tmp_path / "no" / "such.bag")


def test_index_entries_of_one_connection_are_in_the_order_of_time():
    data = bag_bytes([("/c", String(data=str(i)), 50 - i) for i in range(20)], chunk_bytes=100_000)
    at = data.index(b"ver=", data.index(b"op=\x04")) + 8 + 4
    times = [int.from_bytes(data[at + 12 * i : at + 12 * i + 4], "little") for i in range(20)]
    assert times == sorted(times)
    assert [m.data for _, m, _ in read(data)] == [str(19 - i) for i in range(20)]


def test_the_publishers_own_text_is_stored_when_it_is_the_same_definition():
    """rosbag check compares texts with their comments; another definition under that name is not taken."""
    theirs = {
        "type": "std_msgs/String",
        "md5sum": String._md5sum,
        "message_definition": "# words\nstring data\n",
    }
    wrong = {**theirs, "md5sum": "0" * 32}
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write("/same", String(data="x"), 1, header=theirs)
        writer.write("/other", String(data="x"), 1, header=wrong)
        writer.write("/none", String(data="x"), 1, header={"callerid": "/a"})
    bag = read(file.getvalue())
    texts = {c.topic: c.definition for c in bag.connections.values()}
    assert texts == {
        "/same": "# words\nstring data\n",
        "/other": String._full_text,
        "/none": String._full_text,
    }
    assert {c.md5sum for c in bag.connections.values()} == {String._md5sum}
    assert [m.data for _, m, _ in bag.read_messages()] == ["x", "x", "x"]
