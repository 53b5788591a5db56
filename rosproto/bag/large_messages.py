"""Chunks with only a few, large messages: a plain loop is done before numpy has set up its arrays.

A chunk of pictures and laser scans holds about twenty messages, and finding them one by one is quicker than
finding them together with numpy. Where the chunk is not compressed and only bytes are wanted, a large message
is also read from the file straight into the bytes that the caller gets, without reading the chunk first.
Anything unexpected (a record of another form, counts that differ from the table of contents) returns None,
and the chunk is read the general way.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from struct import Struct
from typing import Any, NamedTuple

from rosproto.bag.bag_file import BagFile
from rosproto.bag.records import NS, OP_CONNECTION, ChunkInfo, decode_fields, op_of
from rosproto.bag.rows import MESSAGE_HEAD
from rosproto.errors import BagError

__all__ = ["Found", "Place", "few_alone", "few_messages", "few_places"]

FEW = 256  # messages
LARGE = 4096  # average bytes per message from which messages are read one by one
MOST_BYTES = 64 << 20  # the largest chunk that is read this way
_WINDOW = 16 << 10
_NARROW = 256
_U32 = Struct("<I")
# The head of a message record in the two usual field orders: conn, op, time (roscpp, and our own writer) and
# op, conn, time (rospy). Each struct reads constant bytes, the connection, constant bytes, secs, nsecs and
# the size of the message.
_ORDERS = (
    (Struct("<13sI17sIII"), b"\x26\0\0\0\x09\0\0\0conn=", b"\4\0\0\0op=\2\x0d\0\0\0time="),
    (Struct("<21sI9sIII"), b"\x26\0\0\0\4\0\0\0op=\2\x09\0\0\0conn=", b"\x0d\0\0\0time="),
)


class Place(NamedTuple):
    """A message in a chunk's plain bytes: connection, receive time, where it starts and where it ends."""

    conn: int
    secs: int
    nsecs: int
    start: int
    end: int


class Found(NamedTuple):
    """A message found on its own: connection, receive time, its record's offset in the chunk, size and bytes.

    The bytes of a large message are None: they are read when its turn comes, into memory that the one before
    has just left, which is still in the processor's cache.
    """

    conn: int
    secs: int
    nsecs: int
    offset: int
    size: int
    data: bytes | None


def few_alone(order: Sequence[ChunkInfo]) -> list[bool]:
    """For each of the chunks, sorted by start time: whether it has few messages and overlaps no other."""
    alone: list[bool] = []
    latest = -1
    for number, info in enumerate(order):
        after = order[number + 1].start if number + 1 < len(order) else info.end
        apart = latest <= info.start <= info.end <= after
        alone.append(apart and not info.partial and 0 < sum(info.counts.values()) <= FEW)
        latest = max(latest, info.end)
    return alone


def few_places(blob: bytes, base: int, end: int, counts: Mapping[int, int]) -> list[Place] | None:
    """Where all messages of a chunk are, in time order; None when the general way is needed."""
    places: list[Place] = []
    at, records = base, 0
    make = tuple.__new__
    while at < end:
        head = _head(blob, at, end)
        records += 1
        if head is None or records > 2 * FEW:
            return None
        conn, secs, nsecs, size = head
        start = at + MESSAGE_HEAD
        if conn >= 0:
            at = start + size
            places.append(make(Place, (conn, secs, nsecs, start, at)))
        else:
            at += size
    if at != end or not _agree(places, counts):
        return None
    return places if _in_order(places) else sorted(places, key=lambda p: (p.secs * NS + p.nsecs, p.start))


def few_messages(
    source: BagFile, info: ChunkInfo, position: int, size: int, wanted: Collection[int]
) -> list[Found] | None:
    """The wanted messages of an uncompressed chunk, one by one; None when the general way is needed.

    Args:
        source: The file.
        info: The chunk.
        position: Where its data begins in the file.
        size: Bytes of the data.
        wanted: Connections; large messages of others are not read.

    Raises:
        BagError: The disk fails.
    """
    if not LARGE * sum(info.counts.values()) <= size <= min(MOST_BYTES, source.size - position):
        return None
    found: list[Found] = []
    seen = dict.fromkeys(info.counts, 0)
    read, make = source.read_at, tuple.__new__
    layout, first, second = _ORDERS[0]
    unpack = layout.unpack_from
    at, records, begin, window, end = 0, 0, 0, b"", 0
    last, in_order, ahead = (0, 0), True, _WINDOW
    while at < size:
        if at + MESSAGE_HEAD > end:
            window, begin = read(position + at, min(ahead, size - at)), at
            end = begin + len(window)
        records += 1
        if records > 2 * FEW:
            return None
        head = unpack(window, at - begin) if at + MESSAGE_HEAD <= end else (b"",) * 6
        if head[0] == first and head[2] == second:
            _, conn, _, secs, nsecs, length = head
        else:
            other = _head(window, at - begin, end - begin)
            if other is None and begin < at:  # the window may end too early for this record
                window, begin = read(position + at, min(_WINDOW, size - at)), at
                end = begin + len(window)
                other = _head(window, 0, len(window))
            if other is None:
                return None
            conn, secs, nsecs, length = other
            if conn < 0:
                at += length
                continue
        start = at + MESSAGE_HEAD
        after = start + length
        if after > size or conn not in seen:
            return None
        seen[conn] += 1
        time = secs, nsecs
        if time < last or nsecs >= NS:
            in_order = False
        last = time
        if conn in wanted:
            data = window[start - begin : after - begin] if after <= end else None
            found.append(make(Found, (conn, secs, nsecs, at, length, data)))
        at = after
        # Behind a large message there is probably another one, and more than its head would be read twice.
        ahead = _WINDOW if length < _WINDOW else _NARROW
    if at != size or seen != info.counts:
        return None
    return found if in_order else sorted(found, key=lambda m: (m.secs * NS + m.nsecs, m.offset))


def _head(blob: bytes, at: int, end: int) -> tuple[int, int, int, int] | None:
    """Connection, secs, nsecs and size of the message whose record begins there; None when there is none.

    For a connection record the connection is -1, and the size is that of the whole record.
    """
    if at + MESSAGE_HEAD <= end:
        for layout, first, second in _ORDERS:
            one, conn, two, secs, nsecs, size = layout.unpack_from(blob, at)
            if one == first and two == second:
                return conn, secs, nsecs, size
    if at + 4 > end:
        return None
    data = at + 8 + _U32.unpack_from(blob, at)[0]
    if data > end:
        return None
    try:
        op = op_of(decode_fields(blob, at + 4, data - 4))
    except BagError:
        return None
    return (-1, 0, 0, data + _U32.unpack_from(blob, data - 4)[0] - at) if op == OP_CONNECTION else None


def _agree(messages: Sequence[tuple[Any, ...]], counts: Mapping[int, int]) -> bool:
    """Whether every connection has as many messages as the table of contents says."""
    seen: dict[int, int] = {}
    for message in messages:
        seen[message[0]] = seen.get(message[0], 0) + 1
    return seen == {conn: count for conn, count in counts.items() if count}


def _in_order(messages: Sequence[tuple[Any, ...]]) -> bool:
    last = (0, 0)
    for message in messages:
        time = message[1], message[2]
        if time < last or time[1] >= NS:
            return False
        last = time
    return True
