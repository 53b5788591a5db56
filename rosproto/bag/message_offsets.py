"""Locate the messages in the uncompressed data of a chunk.

A chunk of pictures and laser scans holds about twenty messages, and a plain loop (`walk`) finds them before
numpy has set up its arrays, which makes reading a third faster (`locate_few`). A chunk of 768 KiB of small
messages holds thousands, so numpy finds them all at once: the index records after the chunk give the offsets,
and the message headers there (46 bytes; one writer always has the same fields in the same order) are compared
with the first one and read column by column. Anything else (a wrong index, another field order within the
chunk, a chunk without an index) is read by the loop, and gives the same rows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from struct import Struct
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.bag_file import MAX_CONNECTIONS
from rosproto.bag.records import (
    NS,
    OP_CONNECTION,
    OP_MESSAGE,
    Connection,
    connection_from_fields,
    decode_fields,
    decode_text_fields,
    message_header,
    op_of,
)
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


_MESSAGE_HEADER = 38  # fields conn, op and time with their lengths
MESSAGE_HEAD = 4 + _MESSAGE_HEADER + 4  # with the header's and the data's length

_HEAD_TYPE = f"V{MESSAGE_HEAD}"  # numpy's name for that many bytes

_U32 = Struct("<I")


FEW = 256  # messages
# The head of a message record in the two usual field orders: conn, op, time (roscpp, and our own writer) and
# op, conn, time (rospy). Each struct reads constant bytes, the connection, constant bytes, secs, nsecs and
# the size of the message.
_ORDERS = (
    (Struct("<13sI17sIII"), b"\x26\0\0\0\x09\0\0\0conn=", b"\4\0\0\0op=\2\x0d\0\0\0time="),
    (Struct("<21sI9sIII"), b"\x26\0\0\0\4\0\0\0op=\2\x09\0\0\0conn=", b"\x0d\0\0\0time="),
)

MessageLocation = tuple[int, int, int, int, int]
"""A message: connection, secs, nsecs, its first byte in the chunk's blob, and the one behind it."""


class MessageTable(NamedTuple):
    """Messages of a chunk, one element each, in file order or in time order.

    Attributes:
        conn: Connection id, (N,) uint32.
        secs, nsecs: Receive time as recorded, (N,) uint32.
        start, end: Bytes of the serialized message in the chunk's blob, (N,) int64.
    """

    conn: NDArray[np.uint32]
    secs: NDArray[np.uint32]
    nsecs: NDArray[np.uint32]
    start: NDArray[np.int64]
    end: NDArray[np.int64]

    @property
    def time(self) -> NDArray[np.int64]:
        """Receive time, ns, (N,) int64."""
        import numpy as np

        return self.secs.astype(np.int64) * NS + self.nsecs

    def between(self, low: int | None, high: int | None) -> MessageTable:
        """Rows from `low` to `high`, ns, both included; None is unbounded."""
        if low is None and high is None:
            return self
        first = -1 if low is None else low
        last = 1 << 62 if high is None else high  # later than every stamp
        time = self.time
        return self.take((time >= first) & (time <= last))

    def in_time_order(self) -> MessageTable:
        """Rows sorted by time, then by position in the file."""
        import numpy as np

        time, start = self.time, self.start
        # Checking the order first pays only where sorting takes longer than the check.
        if len(time) >= 256:
            step = time[1:] - time[:-1]
            if ((step > 0) | ((step == 0) & (start[1:] > start[:-1]))).all():
                return self
        return self.take(np.lexsort((start, time)))

    def places(self) -> list[MessageLocation]:
        """The rows as Python integers; nanoseconds beyond a second are carried over."""
        found = list(zip(*[column.tolist() for column in self], strict=True))
        return [_carried(place) for place in found] if (self.nsecs >= NS).any() else found

    def take(self, which: NDArray[np.intp] | NDArray[np.bool_] | slice) -> MessageTable:
        """The rows with these numbers, in this slice, or where the mask is true."""
        conn, secs, nsecs, start, end = self
        return MessageTable(conn[which], secs[which], nsecs[which], start[which], end[which])


def walk(
    blob: bytes, base: int, end: int, tolerant: bool = False, room: int | None = None
) -> tuple[list[MessageLocation], list[Connection]]:
    """Go through a chunk's records one by one.

    Args:
        blob: Bytes that contain the data.
        base: Offset of the data.
        end: Offset of its end.
        tolerant: At damage, return the records before it instead of raising.
        room: The most records allowed; None for any number.

    Returns:
        Locations of the whole messages, in file order, and the connections.

    Raises:
        BagError: A record is damaged, or there are too many.
    """
    limit = end - base if room is None else room
    others = 0
    places: list[MessageLocation] = []
    connections: list[Connection] = []
    at = base
    try:
        while at < end:
            if len(places) + others >= limit:
                raise BagError(
                    f"more than {limit} records in a compressed chunk; it is damaged or crafted to keep "
                    "readers busy; otherwise raise BagLimits.records",
                    offset=at - base,
                )
            for layout, first, second in _ORDERS if at + MESSAGE_HEAD <= end else ():
                one, conn, two, secs, nsecs, size = layout.unpack_from(blob, at)
                if one == first and two == second:
                    start = at + MESSAGE_HEAD
                    after = start + size
                    if after > end:
                        raise BagError(f"a message of {size} bytes is truncated", offset=at - base)
                    places.append((conn, secs, nsecs, start, after))
                    break
            else:  # another kind of record, or a message with another header
                fields, data, after = _record_in(blob, base, at, end)
                op = op_of(fields)
                others += op != OP_MESSAGE
                if op == OP_MESSAGE:
                    places.append((*message_header(fields), data, after))
                elif op == OP_CONNECTION:
                    connections.append(connection_from_fields(fields, decode_text_fields(blob, data, after)))
                    if len(connections) > MAX_CONNECTIONS:
                        raise BagError(
                            f"more than {MAX_CONNECTIONS} connection records in a chunk", offset=at - base
                        )
            at = after
    except BagError:
        if not tolerant:
            raise
    return places, connections


def _record_in(blob: bytes, base: int, at: int, end: int) -> tuple[dict[str, bytes], int, int]:
    """Fields, data position and end of the record at `at`; BagError if it is incomplete."""
    if at + 4 > end:
        raise BagError("a chunk ends inside a record", offset=at - base)
    data = at + 4 + _U32.unpack_from(blob, at)[0] + 4
    if data > end:
        raise BagError("a chunk ends inside a record header", offset=at - base)
    fields = decode_fields(blob, at + 4, data - 4)
    after = data + _U32.unpack_from(blob, data - 4)[0]
    if after > end:
        raise BagError("a chunk ends inside a record's data", offset=at - base)
    return fields, data, after


def table_at_once(blob: bytes, base: int, end: int, offsets: NDArray[np.integer]) -> MessageTable | None:
    """All rows at once; None when the headers at these offsets are not all alike."""
    import numpy as np

    if not len(offsets):
        return table_of([])
    where = offsets.astype(np.int64)
    places = end - base - MESSAGE_HEAD + 1
    if places <= 0 or int(where.max()) >= places or int(where.min()) < 0:
        return None
    # A window at every byte (stride 1): a head may begin anywhere.
    windows = np.ndarray((places,), _HEAD_TYPE, blob, base, (1,))
    return table_of_heads(windows[where], where + base, end)


def table_of_heads(heads: NDArray[np.void], where: NDArray[np.int64], end: int) -> MessageTable | None:
    """The rows of message heads, each of MESSAGE_HEAD bytes, that were at these places; None as above."""
    import numpy as np

    layout = _layout(heads[0].tobytes())
    if layout is None:
        return None
    dtype, constant = layout
    plain = heads.view(np.uint8).reshape(-1, MESSAGE_HEAD)
    if ((plain ^ plain[0]) & constant).any():
        return None
    fields = heads.view(dtype)
    start = where + MESSAGE_HEAD
    stop = start + fields["size"]
    if int(stop.max()) > end:
        return None
    return MessageTable(fields["conn"].copy(), fields["secs"].copy(), fields["nsecs"].copy(), start, stop)


def _layout(head: bytes) -> tuple[np.dtype[np.void], NDArray[np.uint8]] | None:
    """The dtype of a message header of 38 bytes, and a mask of its constant bytes."""
    try:
        fields = decode_fields(head, 4, 4 + _MESSAGE_HEADER)
    except BagError:
        return None
    if sorted(fields) != ["conn", "op", "time"] or op_of(fields) != OP_MESSAGE:
        return None
    if len(fields["conn"]) != 4 or len(fields["time"]) != 8 or _U32.unpack_from(head)[0] != _MESSAGE_HEADER:
        return None
    return _layout_of(tuple(fields))


@lru_cache(maxsize=8)
def _layout_of(names: tuple[str, ...]) -> tuple[np.dtype[np.void], NDArray[np.uint8]]:
    """The same, given the order of the three fields."""
    import numpy as np

    at = 4
    places = {}
    for name in names:
        at += 4 + len(name) + 1
        places[name] = at
        at += {"conn": 4, "op": 1, "time": 8}[name]
    conn, time, size = places["conn"], places["time"], MESSAGE_HEAD - 4
    constant = np.full(MESSAGE_HEAD, 255, np.uint8)
    constant[conn : conn + 4] = constant[time : time + 8] = constant[size:] = 0
    dtype = np.dtype(
        {
            "names": ["conn", "secs", "nsecs", "size"],
            "formats": ["<u4"] * 4,
            "offsets": [conn, time, time + 4, size],
            "itemsize": MESSAGE_HEAD,
        }
    )
    return dtype, constant


def table_of(places: Sequence[MessageLocation]) -> MessageTable:
    """The messages at these locations as a table."""
    import numpy as np

    conn, secs, nsecs, start, stop = np.array(places, np.int64).reshape(-1, 5).T
    return MessageTable(
        conn.astype(np.uint32), secs.astype(np.uint32), nsecs.astype(np.uint32), start.copy(), stop.copy()
    )


def locate_few(
    blob: bytes, base: int, end: int, counts: Mapping[int, int]
) -> Sequence[MessageLocation] | None:
    """Locate all messages of a chunk, in time order, with a plain loop.

    Returns None for more than `FEW` messages and for unexpected data (damage, counts that differ from the
    table of contents); the caller then uses the index.
    """
    if not 0 < sum(counts.values()) <= FEW:
        return None
    try:
        places, _ = walk(blob, base, end, room=2 * FEW)
    except BagError:
        return None
    if Counter([place[0] for place in places]) != {conn: count for conn, count in counts.items() if count}:
        return None
    if _in_order(places):
        return places
    return [_carried(place) for place in sorted(places, key=lambda p: (p[1] * NS + p[2], p[3]))]


def _carried(place: MessageLocation) -> MessageLocation:
    """With less than 10**9 nanoseconds, as in rosbag; unchanged if the seconds would exceed 32 bits."""
    conn, secs, nsecs, start, end = place
    more, rest = divmod(nsecs, NS)
    return place if secs + more > 0xFFFFFFFF else (conn, secs + more, rest, start, end)


def _in_order(places: Sequence[MessageLocation]) -> bool:
    last = (0, 0)
    for place in places:
        time = place[1], place[2]
        if time < last or time[1] >= NS:
            return False
        last = time
    return True
