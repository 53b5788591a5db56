"""Whatever is written to a bag is read from it, in the order of time; and a cut bag gives a part of it."""

from __future__ import annotations

import io
from unittest import mock

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto.bag import BagReader, BagWriter, Connection, time_order
from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import read_head
from rosproto.codec import encode, message_class
from rosproto.time import Time

String = message_class("std_msgs/String")
Numbers = message_class("std_msgs/Float64MultiArray")

stamps = st.builds(Time.from_wire, st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1)) | st.builds(
    Time, st.integers(0, 20), st.sampled_from([0, 1, 999_999_999])
)
strings = st.builds(lambda text: String(data=text), st.text(max_size=30))
arrays = st.builds(lambda values: Numbers(data=values), st.lists(st.floats(allow_nan=False), max_size=400))
messages = st.lists(st.tuples(st.sampled_from(["/a", "/b", "/c/d"]), strings | arrays, stamps), max_size=60)
compressions = st.sampled_from(["none", "bz2", "lz4"])
quick = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def write(what, compression, chunk_bytes, close=True):
    file = io.BytesIO()
    writer = BagWriter(file, compression, chunk_bytes)
    for topic, message, stamp in what:
        writer.write(topic, message, stamp)
    if close:
        writer.close()
    return file.getvalue()


def comparable(entries):
    return [(topic, data, (stamp.secs, stamp.nsecs)) for topic, data, stamp in entries]


def as_read(stamp):
    """Seconds and nanoseconds: nanoseconds beyond a second are carried over, if the seconds then fit."""
    secs, nsecs = divmod(stamp.to_nsec(), 10**9)
    return (secs, nsecs) if secs < 2**32 else (stamp.secs, stamp.nsecs)


def written(entries):
    return [(topic, encode(message), as_read(stamp)) for topic, message, stamp in entries]


@quick
@given(messages, compressions, st.integers(1, 20_000))
def test_what_is_written_is_read(what, compression, chunk_bytes):
    bag = BagReader(io.BytesIO(write(what, compression, chunk_bytes)))
    assert bag.damage == []
    assert bag.message_count == len(what)
    raw = comparable((t, r.data, s) for t, r, s in bag.read_messages(raw=True))
    expected = written(what)
    assert sorted(raw) == sorted(expected)
    times = [secs * 10**9 + nsecs for _, _, (secs, nsecs) in raw]
    assert times == sorted(times)
    assert comparable((t, encode(m), s) for t, m, s in bag) == raw


@quick
@given(messages, compressions, st.integers(1, 20_000))
def test_equal_times_keep_the_order_of_writing(what, compression, chunk_bytes):
    what = [(topic, message, Time(7)) for topic, message, _ in what]
    bag = BagReader(io.BytesIO(write(what, compression, chunk_bytes)))
    raw = comparable((t, r.data, s) for t, r, s in bag.read_messages(raw=True))
    assert raw == written(what)


@quick
@given(
    messages, compressions, st.integers(1, 5000), stamps, stamps, st.sampled_from([None, "/a", ["/a", "/b"]])
)
def test_filters_agree_with_filtering_everything(what, compression, chunk_bytes, start, end, topics):
    bag = BagReader(io.BytesIO(write(what, compression, chunk_bytes)))
    low, high = start.to_nsec(), end.to_nsec()
    names = {"/a", "/b", "/c/d"} if topics is None else {topics} if isinstance(topics, str) else set(topics)
    everything = comparable((t, r.data, s) for t, r, s in bag.read_messages(raw=True))
    expected = [e for e in everything if e[0] in names and low <= e[2][0] * 10**9 + e[2][1] <= high]
    found = comparable((t, r.data, s) for t, r, s in bag.read_messages(topics, start, end, raw=True))
    assert found == expected
    times = sorted(e[2][0] * 10**9 + e[2][1] for e in everything if e[0] == "/a")
    assert bag.times("/a").tolist() == times
    last = bag.message_at("/a", end, raw=True)
    known = [t for t in times if t <= high]
    assert (None if last is None else last[2].to_nsec()) == (known[-1] if known else None)


@quick
@given(messages, compressions, st.integers(1, 5000), st.floats(0, 1), st.booleans())
def test_a_cut_bag_gives_a_part_of_what_was_written(what, compression, chunk_bytes, share, close):
    data = write(what, compression, chunk_bytes, close)
    cut = 13 + int((len(data) - 13) * share)
    bag = BagReader(io.BytesIO(data[:cut]))
    found = comparable((t, r.data, s) for t, r, s in bag.read_messages(raw=True))
    expected = written(what)
    assert len(found) <= len(expected)
    assert sorted(found) == sorted(expected[: len(found)])


@quick
@given(st.lists(st.tuples(st.binary(max_size=200), st.text(max_size=50), stamps), max_size=20), compressions)
def test_raw_bytes_and_definitions_pass_through_unchanged(rows, compression):
    file = io.BytesIO()
    with BagWriter(file, compression, 1000) as writer:
        for number, (data, definition, stamp) in enumerate(rows):
            header = {"callerid": "/p", "latching": str(number % 2)}
            connection = Connection(0, "/t", "pkg/T", "0" * 32, definition, header)
            writer.write_raw(connection, data, stamp)
    bag = BagReader(io.BytesIO(file.getvalue()))
    found = sorted(
        (r.data, r.connection.definition, s.secs, s.nsecs) for _, r, s in bag.read_messages(raw=True)
    )
    assert found == sorted((data, definition, *as_read(s)) for data, definition, s in rows)
    assert all(c.callerid == "/p" for c in bag.connections.values())


sizes = st.integers(0, 60) | st.integers(4000, 9000)
pictures = st.builds(lambda size: String(data="x" * size), sizes)
shuffled = st.lists(st.tuples(st.sampled_from(["/a", "/b"]), pictures, stamps), min_size=5, max_size=60)
budgets = st.integers(1, 3000) | st.integers(3000, 200_000)


@quick
@given(
    shuffled,
    st.sampled_from(["none", "none", "lz4", "bz2"]),
    st.integers(1, 60_000),
    budgets,
    st.sampled_from([None, "/a"]),
    st.none() | stamps,
    st.none() | st.sampled_from([0, 4, 8]),
)
def test_the_order_does_not_depend_on_the_memory(what, compression, chunk_bytes, budget, topic, start, lies):
    data = bytearray(write(what, compression, chunk_bytes))
    if lies is not None:  # the index of the first chunk: time or offset of a message
        source = BagFile(io.BytesIO(data))
        chunk = read_head(source, BagReader(source).chunks[0].pos)
        data[read_head(source, chunk.data_pos + chunk.data_size).data_pos + lies] ^= 1
    bag = BagReader(io.BytesIO(data))
    order = {chunk.pos: n for n, chunk in enumerate(sorted(bag.chunks, key=lambda c: (c.start, c.pos)))}

    def found():
        return [(t, *raw, s) for t, raw, s in bag.read_messages(topic, start, raw=True)]

    expected = found()
    times = [(entry[-1].to_nsec(), order[entry[4][0]], entry[4][1]) for entry in expected]
    assert times == sorted(times)
    if start is None:
        assert len(expected) == sum(topic in (None, t) for t, _, _ in what)
    with mock.patch.object(time_order, "BUDGET_BYTES", budget):
        assert found() == expected
        decoded = [(t, encode(m), s) for t, m, s in bag.read_messages(topic, start)]
    assert decoded == [(entry[0], entry[2], entry[-1]) for entry in expected]
