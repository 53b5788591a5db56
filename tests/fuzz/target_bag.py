"""Fuzz targets of rosproto.bag: what follows a bag's file header, scanned and by its index; and whole files."""

from __future__ import annotations

import io
from collections.abc import Callable

from rosproto.bag import BagReader
from rosproto.bag.records import MAGIC, FileHeader
from rosproto.errors import BagError, RosError

FIRST = len(MAGIC) + len(FileHeader().encode())


def records(data: bytes) -> str:
    """The records of a bag without index: they are scanned."""
    return _read(MAGIC + FileHeader().encode() + data)


def indexed(data: bytes) -> str:
    """A bag whose index starts where the first two bytes say, with as many records as the next two say."""
    position, connections, chunks = int.from_bytes(data[:2], "little"), *data[2:4].ljust(2, b"\0")
    header = FileHeader(FIRST + position, connections, chunks)
    return _read(MAGIC + header.encode() + data[4:])


def whole(data: bytes) -> str:
    """A file from its first byte."""
    return _read(data)


def _read(data: bytes) -> str:
    try:
        tolerant = BagReader(io.BytesIO(data), skip_damaged=True)
    except BagError as error:
        return str(error)
    outcomes = [f"{len(tolerant.damage)} damages"]
    # (Their order is not checked: where index and messages contradict each other, it is the index's.)
    found = sum(len(raw.data) for _, raw, _ in tolerant.read_messages(raw=True))
    outcomes.append("some" if found else "none")
    for attempt in (_decode, _look_around, _strictly):
        try:
            attempt(data)
        except RosError as error:
            outcomes.append(str(error))
    return "; ".join(outcomes)


def _decode(data: bytes) -> None:
    for _ in BagReader(io.BytesIO(data), skip_damaged=True):
        pass


def _look_around(data: bytes) -> None:
    bag = BagReader(io.BytesIO(data), skip_damaged=True)
    for topic in bag.topics:
        assert len(bag.times(topic)) <= len(data)
        bag.frequency(topic)
        bag.message_at(topic, 1e9, raw=True)
    bag.compression()


def _strictly(data: bytes) -> None:
    bag = BagReader(io.BytesIO(data))
    for _ in bag.read_messages(raw=True, start_time=1.0, end_time=1e6):
        pass


TARGETS: dict[str, Callable[[bytes], str]] = {
    "bag_records": records,
    "bag_indexed": indexed,
    "bag_whole": whole,
}

_WORDS = [b"op=%c" % op for op in range(2, 8)] + [
    b"compression=none", b"compression=bz2", b"compression=lz4", b"size=", b"conn=", b"time=", b"ver=\x01\0\0\0",
    b"count=", b"chunk_pos=", b"start_time=", b"end_time=", b"topic=/a", b"type=std_msgs/String", b"md5sum=",
    b"message_definition=string data\n", b"index_pos=", b"chunk_count=", b"conn_count=", b"encryptor=x",
    b"\x04\0\0\0op=", b"\x26\0\0\0\x09\0\0\0conn=", MAGIC,
]  # fmt: skip
TOKENS = dict.fromkeys(TARGETS, _WORDS)
