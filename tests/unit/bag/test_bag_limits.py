"""A bag made to harm: a few kilobytes of bz2 cost neither gigabytes nor minutes, through any door."""

from __future__ import annotations

import bz2
import io
import struct
from pathlib import Path

import pytest

from rosproto.bag import BagLimits, BagReader, BagWriter, time_order
from rosproto.bag.bag_file import MAX_CONNECTIONS, Budget
from rosproto.bag.records import MAGIC, ChunkHeader, FileHeader, encode_fields
from rosproto.cli import main
from rosproto.errors import BagError
from rosproto.time import Time
from tests.support.memory import peak_of
from tests.unit.bag.bagmaker import String

MB = 1 << 20
U32 = struct.Struct("<I").pack
EMPTY = {"type": b"std_msgs/Empty", "md5sum": b"d41d8cd98f00b204e9800998ecf8427e", "message_definition": b""}


def connection(number: int) -> bytes:
    return encode_fields({"conn": U32(number), "op": b"\x07", "topic": b"/a"}) + encode_fields(EMPTY)


def message(odd: bool = False) -> bytes:
    """An empty one; with a header that the quick way does not know."""
    more = {"also": b"x"} if odd else {}
    return encode_fields(more | {"conn": U32(0), "op": b"\x02", "time": U32(1) + U32(1)}) + U32(0)


def chunk(plain: bytes, declared: int | None = None) -> bytes:
    packed = bz2.compress(plain)
    return ChunkHeader("bz2", len(plain) if declared is None else declared).encode(len(packed)) + packed


def scanned(*chunks: bytes) -> bytes:
    """A bag without index, whose chunks are read to find out what is in them."""
    return MAGIC + FileHeader().encode() + b"".join(chunks)


@pytest.fixture(scope="module")
def bomb() -> bytes:
    return scanned(chunk(connection(0) + message() + bytes(100 * MB)))


def test_a_bomb_is_not_unpacked(bomb: bytes) -> None:
    """What a chunk's header declares is compared with the size of the file before memory is taken."""
    assert len(bomb) < 6000
    assert peak_of(lambda: BagReader(io.BytesIO(bomb), skip_damaged=True)) < MB
    bag = BagReader(io.BytesIO(bomb), skip_damaged=True)
    assert bag.message_count == 0
    assert any("BagLimits.expansion" in line for line in bag.damage)


def test_a_header_that_declares_little_gets_no_more() -> None:
    """A chunk that lies about its size is damage; what exceeds its declaration is not unpacked."""
    data = scanned(chunk(bytes(100 * MB), declared=1000))
    assert peak_of(lambda: BagReader(io.BytesIO(data))) < MB
    assert BagReader(io.BytesIO(data)).message_count == 0


@pytest.mark.promise("A larger chunk takes up to four times its size in all")
@pytest.mark.parametrize(
    ("chunk_bytes", "messages", "size"),
    [(24 * MB, 1, 24 * MB), (24 * MB, 96, MB), (MB, 96, MB), (MB // 4, 96 * 16, MB // 16)],
    ids=["one message", "few large chunks", "many chunks", "many messages"],
)
def test_a_small_bag_of_zeros_takes_bounded_memory(
    chunk_bytes: int, messages: int, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`bag filter`, with chunks that all overlap in time; LZ4 packs zeros 255 to 1."""
    path = tmp_path / "in.bag"
    with BagWriter(path, "lz4", chunk_bytes) as bag:
        zeros = String(data="\0" * size)
        for number in range(messages):
            bag.write("/zeros", zeros, 1.0 + number * 7919 % messages)
    monkeypatch.setattr(time_order, "BUDGET_BYTES", 4 * MB)
    words = ["bag", "filter", str(path), str(tmp_path / "out.bag"), "m.data"]
    assert peak_of(lambda: main(words)) < 4 * max(chunk_bytes, size) + 24 * MB
    assert BagReader(tmp_path / "out.bag").message_count == messages


def test_chunks_count_together() -> None:
    """Many chunks that are each small enough are too much together, however the file is cut."""
    some = chunk(connection(0) + message() + bytes(40 * MB))
    bag = BagReader(io.BytesIO(scanned(some, some, some, some)), limits=BagLimits(expansion=1))
    assert sum("BagLimits.expansion" in line for line in bag.damage) == 3


def test_each_chunk_counts_once() -> None:
    """Reading a bag again and again does not use up what it may ask for."""
    bag = BagReader(io.BytesIO(scanned(chunk(connection(0) + 9 * message()))), limits=BagLimits(expansion=1))
    for _ in range(5):
        assert len(list(bag.read_messages(raw=True))) == 9


@pytest.mark.parametrize("odd", [False, True])
def test_records_are_counted(odd: bool) -> None:
    """Records of 50 bytes that pack into nothing cost a thousand times their share of the file."""
    data = scanned(chunk(connection(0) + 3000 * message(odd)))
    limits = BagLimits(records=0, records_spare=1000)
    bag = BagReader(io.BytesIO(data), limits=limits)
    assert bag.message_count <= 1000
    assert any("BagLimits.records" in line for line in bag.damage)
    assert BagReader(io.BytesIO(data)).message_count == 3000


def test_chunk_bytes() -> None:
    """One chunk has a limit of its own."""
    bag = BagReader(io.BytesIO(scanned(chunk(bytes(2000)))), limits=BagLimits(chunk_bytes=1000))
    assert any("at most 1000 are read" in line for line in bag.damage)


def test_connections_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each connection record becomes an object."""
    assert MAX_CONNECTIONS == 65536
    monkeypatch.setattr("rosproto.bag.message_offsets.MAX_CONNECTIONS", 5)
    bag = BagReader(io.BytesIO(scanned(chunk(b"".join(connection(i) for i in range(9))))))
    assert any("more than 5 connection records" in line for line in bag.damage)


def test_an_index_cannot_hide_a_bomb() -> None:
    """With an index nothing is unpacked to open the bag; reading its messages meets the limit."""
    file = io.BytesIO()
    with BagWriter(file, "bz2") as writer:
        writer.write("/a", String(data="a" * MB), Time(1, 0))
    assert len(list(BagReader(file))) == 1
    bag = BagReader(file, limits=BagLimits(expansion=1, expansion_spare=10))
    assert (bag.message_count, bag.damage) == (1, [])
    with pytest.raises(BagError, match=r"BagLimits\.expansion"):
        list(bag)


@pytest.mark.parametrize(
    "words",
    [
        ["info", "{bag}"],
        ["check", "{bag}"],
        ["filter", "{bag}", "{out}", "True"],
        ["export", "{bag}", "csv", "-o", "{dir}"],
        ["compress", "{bag}", "--output-dir", "{dir}"],
        ["fix", "{bag}", "{out}"],
        ["reindex", "{bag}"],
        ["play", "{bag}"],
    ],
    ids=lambda words: words[0],
)
def test_every_door_has_the_limit(words: list[str], bomb: bytes, tmp_path: Path) -> None:
    """Each verb of `rosproto bag` ends at once, with little memory, whatever it then says."""
    bag = tmp_path / "bomb.bag"
    bag.write_bytes(bomb)
    places = {"bag": str(bag), "out": str(tmp_path / "out.bag"), "dir": str(tmp_path / "dir")}
    assert peak_of(lambda: main(["bag", *(word.format(**places) for word in words)])) < 32 * MB


def test_a_budget_counts_the_most_of_each() -> None:
    """The same chunk twice is one chunk; a refusal takes nothing."""
    budget = Budget(10)
    assert budget.take(1, 6)
    assert budget.take(1, 6)
    assert not budget.take(2, 5)
    assert (budget.room(1), budget.room(2)) == (10, 4)
    assert budget.take(2, 4)
