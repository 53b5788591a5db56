"""What happens to a writer once in a thousand bags: large and raw messages, odd orders, Ctrl-C in between."""

from __future__ import annotations

import io
import threading
from typing import Any

import pytest

from rosproto.bag import BagReader, BagWriter, RawMessage
from rosproto.bag.records import Connection
from rosproto.codec import AnyMsg, encode
from rosproto.errors import CodecError
from rosproto.time import Time
from tests.unit.bag.bagmaker import String


def texts(bag: BagReader) -> list[str]:
    return [m.data for _, m, _ in bag.read_messages()]


def big(text: str) -> str:
    return text * 100_000


def test_large_messages_that_were_received_undecoded():
    """Raw ones and AnyMsg, below and above the size of a chunk."""
    header = {"type": "std_msgs/String", "md5sum": String._md5sum, "message_definition": String._full_text}
    connection = Connection(-1, "/raw", "std_msgs/String", String._md5sum, String._full_text)
    file = io.BytesIO()
    with BagWriter(file, chunk_bytes=250_000) as writer:
        for i, letter in enumerate("abcdef"):
            data = encode(String(data=big(letter)))
            writer.write_raw(connection, data, i)
            unknown = AnyMsg()
            unknown._buff, unknown._connection_header = data, header
            writer.write("/any", unknown, i)
        writer.write("/raw", RawMessage("std_msgs/String", b"\1\0\0\0z", "", (0, 0), connection), 9)
    bag = BagReader(file)
    for topic in ("/raw", "/any"):
        assert [m.data[:1] for _, m, _ in bag.read_messages(topic)][:6] == list("abcdef")
    assert bag.message_count == 13


@pytest.mark.parametrize("size", [10, 100_000])
def test_a_time_out_of_range_adds_nothing_whatever_the_size(size):
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write("/said", String(data="x" * size), 1)
        for t in (-1.0, 2.0**32, Time.from_wire(1 << 33, 0)):
            with pytest.raises(ValueError, match="unsigned 32-bit"):
                writer.write("/said", String(data="y" * size), t)
        writer.write("/said", String(data="z" * size), 2)
        with pytest.raises(ValueError, match="a name such as"):
            writer.write("", String(), 3)
    assert [m.data[0] for _, m, _ in BagReader(file).read_messages()] == ["x", "z"]


def test_one_connection_for_a_class_and_raw_messages_of_the_same_facts():
    """Copied and made messages under one topic and header are one connection, in either order."""
    connection = Connection(5, "/said", "std_msgs/String", String._md5sum, String._full_text)
    raw = RawMessage("std_msgs/String", encode(String(data="raw")), String._md5sum, (0, 0), connection)
    for first_raw in (True, False):
        file = io.BytesIO()
        with BagWriter(file) as writer:
            for i in range(4):
                writer.write("/said", raw if (i % 2 == 0) is first_raw else String(data="made"), i)
            writer.write("/said", raw, 4, header={"callerid": "/other"})
            writer.write("/said", String(data="big" * 50_000), 5)
            writer.write("/said", String(data="big" * 50_000), 6)
        bag = BagReader(file)
        assert [c.callerid for c in bag.connections.values()] == ["", "/other"]
        assert sorted({m.data[:4] for _, m, _ in bag.read_messages()}) == ["bigb", "made", "raw"]


def test_a_connection_first_announced_by_somebody_else():
    """Its first message could not be encoded; meanwhile a copied message announced the same connection."""
    connection = Connection(5, "/said", "std_msgs/String", String._md5sum, String._full_text)
    raw = RawMessage("std_msgs/String", encode(String(data="raw")), String._md5sum, (0, 0), connection)
    file = io.BytesIO()
    with BagWriter(file) as writer:
        writer.write_raw(connection, raw.data, 1)
        for t in (2, 3):
            with pytest.raises(CodecError):
                writer.write("/other", String(data=5), t)
            writer.write("/other", raw, t)
        writer.write("/other", String(data="made"), 4)
    bag = BagReader(file)
    assert texts(bag) == ["raw", "raw", "raw", "made"]
    assert len(bag.connections) == 2


class Interrupted(list[int]):
    """Ctrl-C in the moment between a connection's record and its first message."""

    def __iadd__(self, more: Any) -> Any:
        raise KeyboardInterrupt


def test_ctrl_c_between_a_connection_and_its_first_message():
    """The chunk then has a connection and no message; the bag is whole and can be read."""
    file = io.BytesIO()
    writer = BagWriter(file)
    writer._find_out("/said", String(), None)[0].index = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        writer.write("/said", String(), 1)
    writer.close()
    bag = BagReader(file)
    assert (bag.damage, bag.message_count) == ([], 0)


def test_ctrl_c_while_a_chunk_is_compressed_loses_nothing(monkeypatch):
    from rosproto.bag import output

    def interrupted(tasks: Any) -> None:
        raise KeyboardInterrupt

    file = io.BytesIO()
    writer = BagWriter(file, "lz4", 70_000)
    writer.write("/said", String(data=big("x")), 1)
    with monkeypatch.context() as context:
        context.setattr(output, "wait", interrupted)
        with pytest.raises(KeyboardInterrupt):
            writer.flush()
    writer.close()
    assert [m.data[0] for _, m, _ in BagReader(file).read_messages()] == ["x"]


def test_a_large_message_may_end_what_is_written_at_once(tmp_path):
    """Pieces are gathered whatever their order: small ones last, or none at all."""
    from rosproto.bag.output import BagOutputFile

    large = b"L" * 100_000
    for pieces in ([large], [b"s", large], [large, b"s"], [b"s"], []):
        output = BagOutputFile(tmp_path / "x", keep=False)
        assert output.put(pieces, 3) == 3 + sum(map(len, pieces))
        output.close()
        assert (tmp_path / "x").read_bytes()[3:] == b"".join(pieces)


class Crossed(list[int]):
    """Another thread writes in the moment between a message's offset and its bytes, if it may."""

    def __init__(self, other: threading.Thread) -> None:
        super().__init__()
        self.other = other

    def __iadd__(self, more: Any) -> Any:
        self.other.start()
        self.other.join(0.2)
        return super().__iadd__(more)


def test_threads_that_share_a_writer_lose_nothing():
    """As the callbacks of several subscribers do."""
    file = io.BytesIO()
    with BagWriter(file) as writer:
        other = threading.Thread(target=writer.write, args=("/b", String(data="b"), 2))
        writer._find_out("/a", String(), None)[0].index = Crossed(other)
        writer.write("/a", String(data="a"), 1)
        other.join(10)
    bag = BagReader(file)
    assert (bag.damage, texts(bag)) == ([], ["a", "b"])
