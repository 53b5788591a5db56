"""Read one chunk of a bag: its header, its uncompressed data and its index."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from struct import Struct
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.bag_file import BagFile, Budget
from rosproto.bag.compression import decompress, decompress_prefix
from rosproto.bag.message_offsets import (
    MESSAGE_HEAD,
    MessageLocation,
    MessageTable,
    locate_few,
    table_at_once,
    table_of,
    table_of_heads,
    walk,
)
from rosproto.bag.records import (
    INDEX_ENTRY_BYTES,
    NS,
    OP_CHUNK,
    OP_INDEX,
    ChunkHeader,
    ChunkInfo,
    Connection,
    decode_fields,
    index_header,
    op_of,
)
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


_AT_ONCE = 4 << 20
_MIN_READ = 4096  # bytes of a chunk for each wanted message, so that reading them one by one is faster
_HEAD_BYTES = 512  # more than any record header that is not a connection's
_MAX_HEADER_BYTES = 1 << 20

_U32 = Struct("<I")


class RecordHead(NamedTuple):
    """A record in the file: header fields, position of the data, and declared data length."""

    fields: dict[str, bytes]
    op: int
    data_pos: int
    data_size: int


def read_head(source: BagFile, pos: int, begin: bytes = b"") -> RecordHead:
    """Read the head of the record at `pos`.

    Args:
        source: The file.
        pos: Position of the record.
        begin: Bytes from `pos` on that were read already.

    Raises:
        BagError: The record head is incomplete or invalid.
    """
    head = begin or source.read_at(pos, _HEAD_BYTES)
    if len(head) < 4:
        raise source.error("the file ends inside a record", pos)
    (size,) = _U32.unpack_from(head)
    if size > _MAX_HEADER_BYTES:
        raise source.error(f"a record header of {size} bytes; the file is damaged here", pos)
    if len(head) < size + 8:
        head = source.read_at(pos, size + 8)
        if len(head) < size + 8:
            raise source.error("the file ends inside a record header", pos)
    try:
        fields = decode_fields(head, 4, 4 + size)
    except BagError as problem:
        raise source.error(str(problem), pos) from None
    (data_size,) = _U32.unpack_from(head, 4 + size)
    op = op_of(fields)
    if op == OP_INDEX:
        # Early rosbag (C Turtle) wrote a wrong data length here; the count decides, as in rosbag's readers.
        data_size = index_header(fields)[1] * INDEX_ENTRY_BYTES
    return RecordHead(fields, op, pos + size + 8, data_size)


@dataclass(slots=True)
class ChunkData:
    """The uncompressed data of a chunk.

    Attributes:
        info: The chunk.
        blob: Bytes that contain the plain data (an uncompressed chunk is kept as it was read, not copied).
        base: Where the data starts in `blob`.
        end: Where it ends.
        complete: False when some of the data is missing.
        compression: "none", "bz2" or "lz4", as in the file.
        budget: How many records it may have; None for as many as there are.
        tail: Bytes with the index records, and their offset; None without a usable index.
    """

    info: ChunkInfo
    blob: bytes
    base: int
    end: int
    complete: bool = True
    compression: str = "none"
    budget: Budget | None = None
    tail: tuple[bytes, int] | None = None

    def rows(self, wanted: Collection[int] | None = None) -> MessageTable:
        """The messages of the wanted connections (None: all), in file order for each connection.

        Raises:
            BagError: A record is damaged (in a partial chunk, the messages before the damage are returned
                instead).
        """
        import numpy as np

        index = None if self.tail is None else _indexed(*self.tail, self.info, wanted)
        if index is None:
            return self._walked(wanted)
        offsets, conns = index
        rows = table_at_once(self.blob, self.base, self.end, offsets)
        if rows is None or not np.array_equal(rows.conn, conns):
            return self._walked(wanted)  # the index is wrong, or the messages differ in the order of fields
        return rows

    def places(
        self, wanted: Collection[int], low: int | None = None, high: int | None = None
    ) -> Sequence[MessageLocation]:
        """Locations of the messages of these connections in this time span (ns), in time order.

        Raises:
            BagError: The chunk is damaged.
        """
        found = None
        if not self.info.partial:
            found = locate_few(self.blob, self.base, self.end, self.info.counts)
        if found is None:
            return self.rows(wanted).between(low, high).in_time_order().places()
        if not self.info.counts.keys() <= set(wanted):
            found = [place for place in found if place[0] in wanted]
        if low is not None and self.info.start < low:
            found = [place for place in found if place[1] * NS + place[2] >= low]
        if high is not None and self.info.end > high:
            found = [place for place in found if place[1] * NS + place[2] <= high]
        return found

    def connections(self) -> list[Connection]:
        """The connection records inside."""
        return self._walk()[1]

    def _walk(self) -> tuple[list[MessageLocation], list[Connection]]:
        room = None if self.budget is None else self.budget.room(self.info.pos)
        places, connections = walk(self.blob, self.base, self.end, not self.complete, room)
        if self.budget is not None:
            self.budget.take(self.info.pos, len(places) + len(connections))
        return places, connections

    def _walked(self, wanted: Collection[int] | None) -> MessageTable:
        import numpy as np

        rows = table_of(self._walk()[0])
        return rows if wanted is None else rows.take(np.isin(rows.conn, np.fromiter(wanted, np.uint32)))


def read_chunk(
    source: BagFile, info: ChunkInfo, span: int, *, with_index: bool = True, max_bytes: int | None = None
) -> ChunkData:
    """Read and decompress a chunk.

    Args:
        source: The file.
        info: The chunk; a `partial` one is read up to its end.
        span: Bytes up to the next chunk: the chunk and the index records after it.
        with_index: Also read the index records.
        max_bytes: Bytes it may have, stored or uncompressed; None: as many as `BagLimits` allow.

    Raises:
        BagError: It is damaged, or larger.
    """
    # Read the chunk and its index at once, unless they may be large.
    whole = source.read_at(info.pos, span) if with_index and span <= _AT_ONCE else b""
    head = _chunk_head(source, info.pos, whole)
    chunk = ChunkHeader.from_fields(head.fields)
    size = max(chunk.size, head.data_size)
    max_bytes = source.limits.chunk_bytes if max_bytes is None else min(max_bytes, source.limits.chunk_bytes)
    if size > max_bytes:
        raise source.error(f"a chunk of {size} bytes, at most {max_bytes} are read", info.pos)
    in_file = source.size - head.data_pos
    if head.data_size or not info.partial:  # a crashed recorder leaves 0 here, followed by its data
        in_file = min(in_file, head.data_size)
    base = head.data_pos - info.pos
    tail = max(0, span - base - head.data_size) if with_index else 0
    # An index is never larger than what it indexes.
    tail = min(tail, 64 + (INDEX_ENTRY_BYTES + 1) * chunk.size)
    raw = whole
    if len(whole) < base + in_file + tail:
        raw, base = source.read_at(head.data_pos, in_file + tail), 0
    end = min(base + in_file, len(raw))
    indexed = with_index and info.indexed and not info.partial
    if chunk.compression == "none":
        # Stored as it is: both sizes of its header agree, and all of these bytes are there.
        complete = len(raw) - base >= head.data_size == chunk.size and not info.partial
        if not complete and not info.partial:
            raise source.error("an uncompressed chunk is shorter than its header says", info.pos)
        index = (raw, end) if indexed else None
        return ChunkData(info, raw, base, end, complete, tail=index)
    packed = memoryview(raw)[base:end]
    declared = chunk.size
    if info.partial and not declared:
        # A crashed recorder left no size: allow the most that a chunk of this length can expand to.
        declared = min(max_bytes, source.limits.expansion_spare + source.limits.expansion * len(packed))
    source.allow_unpacking(info.pos, declared)
    try:
        if info.partial:
            plain, complete = decompress_prefix(chunk.compression, packed, declared)
        else:
            plain, complete = decompress(chunk.compression, packed, chunk.size), True
    except BagError as problem:
        raise source.error(str(problem), info.pos) from None
    index = (raw[end : end + tail], 0) if indexed else None
    return ChunkData(info, plain, 0, len(plain), complete, chunk.compression, source.records, index)


class UnreadChunk(NamedTuple):
    """An uncompressed chunk of which only the heads of the wanted messages have been read.

    Attributes:
        rows: The messages; their places are counted from the beginning of the chunk's data.
        read: Returns a message, by its places.
    """

    rows: MessageTable
    read: Callable[[int, int], bytes]


def read_heads(source: BagFile, info: ChunkInfo, span: int, wanted: Collection[int]) -> UnreadChunk | None:
    """Read the heads of a chunk's wanted messages; the arguments are those of `read_chunk`.

    Returns:
        None where `read_chunk` is to be used: messages are small, or the chunk is compressed or damaged.
    """
    try:
        head = _chunk_head(source, info.pos)
        chunk = ChunkHeader.from_fields(head.fields)
        base, size = head.data_pos, chunk.size
        count = sum(info.counts.get(conn, 0) for conn in wanted)
        if chunk.compression != "none" or info.partial or not info.indexed or count * _MIN_READ > size:
            return None
        if head.data_size != size or base + size > source.size:
            return None
        rows = _rows_of_heads(source, info, base, size, info.pos + span, wanted)
    except BagError:
        return None
    if rows is None:
        return None

    def read(start: int, end: int) -> bytes:
        source.check_open()
        data = source.read_at(base + start, end - start)
        if len(data) < end - start:
            raise source.error("the bag changed while it was read", info.pos)
        return data

    return UnreadChunk(rows, read)


def _rows_of_heads(
    source: BagFile, info: ChunkInfo, base: int, size: int, behind: int, wanted: Collection[int]
) -> MessageTable | None:
    """The wanted messages of the chunk data at `base`, and its index, up to `behind`; None if it is wrong."""
    import numpy as np

    index = _indexed(source.read_at(base + size, min(behind - base - size, _AT_ONCE)), 0, info, wanted)
    if index is None or not len(index[0]):
        return None
    offsets = index[0].astype(np.int64)
    raw = b"".join([source.read_at(base + offset, MESSAGE_HEAD) for offset in offsets.tolist()])
    if int(offsets.max()) > size - MESSAGE_HEAD or len(raw) != MESSAGE_HEAD * len(offsets):
        return None
    rows = table_of_heads(np.frombuffer(raw, f"V{MESSAGE_HEAD}"), offsets, size)
    return rows if rows is not None and np.array_equal(rows.conn, index[1]) else None


def _chunk_head(source: BagFile, pos: int, begin: bytes = b"") -> RecordHead:
    head = read_head(source, pos, begin)
    if head.op != OP_CHUNK:
        raise source.error(f"expected a chunk record, found op {head.op}", pos)
    return head


def chunk_header(source: BagFile, info: ChunkInfo) -> tuple[ChunkHeader, int]:
    """Return a chunk's header and its size in the file.

    Raises:
        BagError: There is no chunk.
    """
    head = _chunk_head(source, info.pos)
    left = source.size - head.data_pos
    # A crashed recorder leaves 0 as the size of its last chunk, whose data goes on to the end of the file.
    return ChunkHeader.from_fields(head.fields), min(head.data_size, left) if head.data_size else left


def read_index_times(
    source: BagFile, info: ChunkInfo, span: int, wanted: Collection[int]
) -> NDArray[np.int64] | None:
    """Receive times (ns) of the wanted connections' messages, from the index records alone.

    Returns:
        (N,) int64, in no particular order; None when the index records are not usable.
    """
    import numpy as np

    if not info.indexed or info.partial:
        return None
    try:
        head = _chunk_head(source, info.pos)
        ChunkHeader.from_fields(head.fields)
        start = head.data_pos + head.data_size
        raw = source.read_at(start, info.pos + span - start)
        times = [np.zeros(0, np.int64)]
        for fields, at in _index_records(raw, 0):
            conn, count = index_header(fields)
            if conn in wanted:
                entries = np.frombuffer(raw, "<u4", 3 * count, at)
                times.append(entries[0::3].astype(np.int64) * NS + entries[1::3])
    except (BagError, ValueError):
        return None
    found = np.concatenate(times)
    return found if len(found) == sum(info.counts.get(conn, 0) for conn in wanted) else None


def _read_index(raw: bytes, start: int, info: ChunkInfo) -> dict[int, NDArray[np.uint32]] | None:
    """Offsets by connection id from the index records at `start`; None unless they agree with `info`."""
    import numpy as np

    index: dict[int, NDArray[np.uint32]] = {}
    try:
        for fields, at in _index_records(raw, start):
            conn, count = index_header(fields)
            entries = np.frombuffer(raw, "<u4", 3 * count, at)
            index[conn] = np.concatenate([index[conn], entries[2::3]]) if conn in index else entries[2::3]
    except (BagError, ValueError):
        return None
    if {conn: len(offsets) for conn, offsets in index.items() if len(offsets)} != {
        conn: count for conn, count in info.counts.items() if count
    }:
        return None
    return index


def _indexed(
    raw: bytes, start: int, info: ChunkInfo, wanted: Collection[int] | None
) -> tuple[NDArray[np.uint32], NDArray[np.uint32]] | None:
    """Offset and connection id of each wanted message, from the index records at `start`; None as above."""
    import numpy as np

    index = _read_index(raw, start, info)
    if index is None:
        return None
    chosen = {conn: o for conn, o in index.items() if wanted is None or conn in wanted}
    conns = np.repeat(np.fromiter(chosen, np.uint32), [len(o) for o in chosen.values()])
    return np.concatenate([np.zeros(0, np.uint32), *chosen.values()]), conns


def _index_records(raw: bytes, at: int) -> Iterator[tuple[dict[str, bytes], int]]:
    """Fields and data position of the index records at `at`; ends at the first record of another kind."""
    while at + 4 <= len(raw):
        size = _U32.unpack_from(raw, at)[0]
        data = at + 4 + size + 4
        if data > len(raw):
            return
        fields = decode_fields(raw, at + 4, at + 4 + size)
        if op_of(fields) != OP_INDEX:
            return
        yield fields, data
        at = data + INDEX_ENTRY_BYTES * index_header(fields)[1]
