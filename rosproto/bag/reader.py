"""Read bags: everything a recorder leaves behind, whether it was closed properly or crashed."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, BinaryIO, Literal, NamedTuple

from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import ChunkData, chunk_header, plain_data, read_chunk, read_index_times
from rosproto.bag.few import Found, few_alone, few_messages, few_places
from rosproto.bag.index import open_index
from rosproto.bag.limits import BagLimits
from rosproto.bag.merge import Batch, merge
from rosproto.bag.read_ahead import Following, ReadAhead
from rosproto.bag.records import NS, ChunkInfo, Connection, total_counts
from rosproto.bag.rows import MESSAGE_HEAD, Rows
from rosproto.bag.stamps import Stamp, to_ns
from rosproto.errors import BagError
from rosproto.time import Time

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosproto.codec import Message

__all__ = ["BagReader", "Compression", "RawMessage", "TopicInfo"]

Give = Callable[[bytes, int, int], Any]


class RawMessage(NamedTuple):
    """A message as it lies in the bag; the first four are what rosbag gives with raw=True.

    Attributes:
        type: "package/Type".
        data: Serialized message; a read-only memoryview of the chunk with raw="view".
        md5sum: Of its definition.
        position: (byte position of the chunk in the file, of the message in the uncompressed chunk).
        connection: Its connection, with the definition; `BagWriter.write` stores it as it is.
    """

    type: str
    data: bytes
    md5sum: str
    position: tuple[int, int]
    connection: Connection


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """One topic of a bag.

    Attributes:
        types: Message types, usually one.
        message_count: Messages on all its connections.
        connections: Its connections (one for each publisher and definition).
    """

    types: tuple[str, ...]
    message_count: int
    connections: tuple[Connection, ...]


@dataclass(frozen=True, slots=True)
class Compression:
    """Chunks with one kind of compression: how many, their bytes in the file and uncompressed."""

    chunks: int
    stored_bytes: int
    plain_bytes: int


class BagReader:
    """A bag, opened for reading.

    Opening reads the table of contents only. A bag without a usable one (never closed, cut off, damaged) is
    scanned record by record; `damage` then says what was wrong, and everything that is whole can be read.

    Args:
        file: Path, or a seekable binary file.
        skip_damaged: When a chunk turns out to be damaged, leave out the rest of it and note that in
            `damage`, instead of raising.
        limits: How much reading the file may cost; see `rosproto.bag.BagLimits`.

    Raises:
        BagError: It cannot be opened, is no bag, is of version 1, or is encrypted.

    Attributes:
        path: Path of the file, None when there is none.
        size: Bytes of the file.
        damage: What was wrong with the file, in words; empty for a sound bag.
        version: Of the format, "2.0" as a rule.
        indexed: False when the file had no usable table of contents and was scanned.
        connections: All connections with messages, by id.
        topics: `TopicInfo` by topic, sorted.
        message_count: Messages in the bag.
        chunks: What each chunk holds, in file order.
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO,
        *,
        skip_damaged: bool = False,
        limits: BagLimits | None = None,
    ) -> None:
        self._source = BagFile(file, limits)
        try:
            found = open_index(self._source)
        except BaseException:
            self._source.close()
            raise
        self._skip = skip_damaged
        self._spans = found.spans()
        self._take_contents(found.connections, found.chunks, found.damage)
        self.version = found.version
        self.indexed = found.closed

    def _take_contents(
        self, connections: dict[int, Connection], chunks: list[ChunkInfo], damage: list[str]
    ) -> None:
        self._functions: dict[int, Give] = {}
        self.path = self._source.path
        self.size = self._source.size
        self.damage = damage
        self.chunks: tuple[ChunkInfo, ...] = tuple(chunks)
        counts = total_counts(chunks)
        self._counts = counts
        self.connections = MappingProxyType({i: c for i, c in sorted(connections.items()) if counts.get(i)})
        self._known = {i: (c.topic, c.type, c.md5sum, c) for i, c in self.connections.items()}
        self.topics = MappingProxyType(self._make_topics())
        self.message_count = sum(counts.values())

    def __enter__(self) -> BagReader:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, if it was opened here. Iterators still under way fail."""
        self._source.close()

    def __repr__(self) -> str:
        return (
            f"<BagReader {self.path or 'stream'}: {self.message_count} messages on {len(self.topics)} topics>"
        )

    def __len__(self) -> int:
        return self.message_count

    def __iter__(self) -> Iterator[tuple[str, Any, Time]]:
        return self.read_messages()

    @property
    def start_time(self) -> Time | None:
        """Receive time of the earliest message, None for an empty bag."""
        return _as_time(min(c.start for c in self.chunks)) if self.chunks else None

    @property
    def end_time(self) -> Time | None:
        """Receive time of the latest message, None for an empty bag."""
        return _as_time(max(c.end for c in self.chunks)) if self.chunks else None

    @property
    def duration(self) -> float:
        """Seconds from the earliest to the latest message, 0 for an empty bag."""
        if not self.chunks:
            return 0.0
        return (max(c.end for c in self.chunks) - min(c.start for c in self.chunks)) / NS

    def read_messages(
        self,
        topics: str | Iterable[str] | None = None,
        start_time: Stamp | None = None,
        end_time: Stamp | None = None,
        raw: bool | Literal["view"] = False,
        *,
        connections: Iterable[Connection] | None = None,
    ) -> Iterator[tuple[str, Any, Time]]:
        """Messages in the order they were received.

        Whatever the size of the bag, memory holds one chunk, or the few that overlap in time (and a few more
        when chunks are compressed, because helper threads read ahead). The arrays of a message that makes up
        a quarter of its chunk or more are views of the chunk and keep it in memory as long as they live;
        smaller messages have bytes of their own.

        Args:
            topics: Only these.
            start_time: Not earlier than this: a Time, or seconds.
            end_time: Not later than this.
            raw: Yield `RawMessage`, not decoded. With "view" its data is a memoryview of the chunk, not a
                copy; keeping one keeps the whole chunk in memory.
            connections: Only these.

        Yields:
            Topic, message (its arrays are read-only), receive time.

        Raises:
            BagError: A chunk is damaged (see `skip_damaged`), or a connection has no usable definition.
            CodecError: A message does not fit its stored definition.
            ValueError: `raw` is a string other than "view".
        """
        if raw not in (False, True, "view"):
            raise ValueError(f'raw={raw!r}: True, False or "view"')
        wanted = self._wanted(topics, connections)
        low = None if start_time is None else to_ns(start_time)
        high = None if end_time is None else to_ns(end_time)
        return self._read_messages(wanted, low, high, raw)

    def _read_messages(
        self, wanted: set[int], low: int | None, high: int | None, raw: bool | str
    ) -> Iterator[tuple[str, Any, Time]]:
        view = raw == "view"
        ahead = ReadAhead(self._source, self._spans)
        order = self._chunks_of(wanted, low, high)
        alone = self._alone(order)
        number = 0
        while number < len(order):
            first, info = number, order[number]
            if not alone[first]:
                while number < len(order) and not alone[number]:
                    number += 1
                for batch in self._merge(order[first:number], ahead, wanted, low, high):
                    yield from self._of_batch(batch, raw, view)
                continue
            number += 1
            # Only for a chunk that lies wholly in the span: its messages are not filtered by time below.
            whole = (low is None or info.start >= low) and (high is None or info.end <= high)
            if whole and raw and not view and (found := self._few_messages(info, wanted)) is not None:
                yield from self._raw_found(info, found)
                continue
            data = self._load(info, ahead, lambda count, at=number: order[at : at + count])  # type: ignore[misc]
            if data is None:
                continue
            places = few_places(data.blob, data.base, data.end, info.counts) if whole else None
            if places is None:
                for batch in merge([info], lambda *_, held=data: held, self._selector(wanted, low, high)):
                    yield from self._of_batch(batch, raw, view)
                continue
            if not info.counts.keys() <= wanted:
                places = [place for place in places if place.conn in wanted]
            if raw:
                base = data.base + MESSAGE_HEAD
                yield from self._raw_places(info, memoryview(data.blob) if view else data.blob, base, places)
            else:
                yield from self._decoded(data.blob, [place.conn for place in places], places)
            del data, places  # the next chunk is read into the same memory, still in the cache

    def _alone(self, order: list[ChunkInfo]) -> list[bool]:
        return few_alone(order)

    def _few_messages(self, info: ChunkInfo, wanted: set[int]) -> list[Found] | None:
        """A chunk's messages read one by one; None where that is slower, or the chunk is damaged."""
        self._source.check_open()
        if self._source.far:
            return None
        try:
            position, size = plain_data(self._source, info)
            return few_messages(self._source, info, position, size, wanted) if size else None
        except BagError:
            return None  # the general way reports what is wrong

    def _of_batch(self, batch: Batch, raw: bool | str, view: bool) -> Iterator[tuple[str, Any, Time]]:
        if raw:
            return self._raw_messages(batch, view)
        if batch.chunk is not None:
            columns = [column.tolist() for column in batch.rows]
            return self._decoded(batch.chunk.blob, columns[0], zip(*columns, strict=True))
        return self._merged_messages(batch)

    def message_at(self, topic: str, time: Stamp, *, raw: bool = False) -> tuple[str, Any, Time] | None:
        """The latest message on a topic received at or before a time; None when there is none.

        Reads one chunk where chunks do not overlap.
        """
        limit = to_ns(time)
        wanted = self._wanted(topic, None)
        best: tuple[int, ChunkData, Rows] | None = None
        chunks = [c for c in self.chunks if c.start <= limit and not wanted.isdisjoint(c.counts)]
        for info in sorted(chunks, key=lambda c: (min(c.end, limit), c.pos), reverse=True):
            if best is not None and info.end < best[0]:
                break
            data = self._load(info)
            rows = None if data is None else self._select(data, wanted, None, limit)
            if data is not None and rows is not None and len(rows.conn):
                times = rows.time
                last = len(times) - 1 - int(times[::-1].argmax())
                if best is None or times[last] > best[0]:
                    best = int(times[last]), data, rows.take(_one(last))
        if best is None:
            return None
        batch = Batch(best[2], best[1])
        return next(self._of_batch(batch, raw, False))

    def times(self, topic: str) -> NDArray[np.int64]:
        """Receive times of a topic's messages, ns, sorted, (N,) int64; reads index records, not messages."""
        import numpy as np

        wanted = self._wanted(topic, None)
        parts: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
        for info in self.chunks:
            if wanted.isdisjoint(info.counts):
                continue
            times = read_index_times(self._source, info, self._spans[info.pos], wanted)
            if times is None:
                data = self._load(info)
                rows = None if data is None else self._select(data, wanted, None, None)
                times = rows.time if rows is not None else parts[0]
            parts.append(times)
        return np.sort(np.concatenate(parts))

    def frequency(self, topic: str) -> float | None:
        """Messages per second: one over the median interval, as in rosbag; None below two messages."""
        import numpy as np

        times = self.times(topic)
        if len(times) < 2:
            return None
        period = float(np.median(np.diff(times))) / NS
        return 1.0 / period if period > 0 else None

    def compression(self) -> dict[str, Compression]:
        """How the chunks are compressed, by "none", "bz2" and "lz4"; reads their headers."""
        kinds: dict[str, Compression] = {}
        for info in self.chunks:
            head, stored = chunk_header(self._source, info)
            was = kinds.get(head.compression, Compression(0, 0, 0))
            kinds[head.compression] = Compression(
                was.chunks + 1, was.stored_bytes + stored, was.plain_bytes + (head.size or stored)
            )
        return kinds

    def message_class(self, which: str | Connection) -> type[Message]:
        """The class that messages of a topic (its first connection) or of a connection are decoded to.

        Raises:
            BagError: No such topic, or no usable definition.
        """
        from rosproto.bag.types import message_class_of

        if isinstance(which, str):
            which = self._topic(which).connections[0]
        return message_class_of(which)

    def to_numpy(self, topic: str, fields: Iterable[str]) -> dict[str, NDArray[Any]]:
        """Columns of a topic: see `rosproto.bag.columns.to_numpy`.

        Raises:
            BagError: No such topic, or no such field; the message lists what there is.
        """
        from rosproto.bag.columns import to_numpy

        return to_numpy(self, topic, self._topic(topic).connections, fields)

    def to_arrow(
        self,
        topic: str,
        fields: Iterable[str] | None = None,
        *,
        start_time: Stamp | None = None,
        end_time: Stamp | None = None,
    ) -> Any:
        """A topic as a `pyarrow.RecordBatchReader`: batches of bounded size, read on demand.

        `.read_all()` makes a Table of it, `.read_pandas()` a DataFrame, and `polars.from_arrow` takes that
        Table. Needs the extra `arrow`. `rosproto.bag.arrow.schema_of` says how fields map to columns.

        Args:
            topic: The topic; all its messages must have the same definition.
            fields: Paths such as "pose.pose.position.x", each a column; None for the whole message. Other
                fields are not decoded.
            start_time: Not earlier than this: a Time, or seconds.
            end_time: Not later than this.

        Raises:
            BagError: No such topic or field, several definitions, or no pyarrow. While batches are read, the
                errors of `read_messages`, which pyarrow passes on unchanged.
        """
        from rosproto.bag.arrow import to_arrow

        return to_arrow(self, topic, self._topic(topic).connections, fields, start_time, end_time)

    def batches(self, topic: str) -> Iterator[Batch]:
        """Where the messages of a topic lie, chunk by chunk: for callers that need bytes, not objects.

        Raises:
            BagError: A chunk is damaged (see `skip_damaged`).
        """
        return self._batches(self._wanted(topic, None), None, None)

    def _topic(self, topic: str) -> TopicInfo:
        try:
            return self.topics[topic]
        except KeyError:
            known = ", ".join(self.topics) or "none at all"
            raise self._source.error(f"no messages on topic {topic!r}; the bag has {known}") from None

    def _make_topics(self) -> dict[str, TopicInfo]:
        by_topic: dict[str, list[Connection]] = {}
        for connection in self.connections.values():
            by_topic.setdefault(connection.topic, []).append(connection)
        return {
            topic: TopicInfo(
                tuple(sorted({c.type for c in group})), sum(self._counts[c.id] for c in group), tuple(group)
            )
            for topic, group in sorted(by_topic.items())
        }

    def _wanted(
        self, topics: str | Iterable[str] | None, connections: Iterable[Connection] | None
    ) -> set[int]:
        chosen = set(self.connections)
        if topics is not None:
            names = {topics} if isinstance(topics, str) else set(topics)
            chosen = {i for i in chosen if self.connections[i].topic in names}
        if connections is not None:
            chosen &= {c.id for c in connections}
        return chosen

    def _chunks_of(self, wanted: Collection[int], low: int | None, high: int | None) -> list[ChunkInfo]:
        """Chunks that have wanted messages, by start time."""
        chunks = [
            c
            for c in self.chunks
            if (low is None or c.end >= low)
            and (high is None or c.start <= high)
            and not c.counts.keys().isdisjoint(wanted)
        ]
        return sorted(chunks, key=lambda c: (c.start, c.pos))

    def _batches(self, wanted: Collection[int], low: int | None, high: int | None) -> Iterator[Batch]:
        ahead = ReadAhead(self._source, self._spans)
        return self._merge(self._chunks_of(wanted, low, high), ahead, wanted, low, high)

    def _merge(
        self,
        chunks: list[ChunkInfo],
        ahead: ReadAhead,
        wanted: Collection[int],
        low: int | None,
        high: int | None,
    ) -> Iterator[Batch]:
        return merge(
            chunks,
            lambda info, following: self._load(info, ahead, following),
            self._selector(wanted, low, high),
        )

    def _selector(
        self, wanted: Collection[int], low: int | None, high: int | None
    ) -> Callable[[ChunkData], Rows | None]:
        return lambda data: self._select(data, wanted, low, high)

    def _load(
        self, info: ChunkInfo, ahead: ReadAhead | None = None, following: Following | None = None
    ) -> ChunkData | None:
        self._source.check_open()
        try:
            if ahead is not None:
                return ahead.take(info, following)
            return read_chunk(self._source, info, self._spans[info.pos])
        except BagError as problem:
            self._skipped(info, problem)
            return None

    def _select(
        self, data: ChunkData, wanted: Collection[int], low: int | None, high: int | None
    ) -> Rows | None:
        try:
            rows = data.rows(wanted)
        except BagError as problem:
            self._skipped(data.info, problem)
            return None
        if (low is None or data.info.start >= low) and (high is None or data.info.end <= high):
            return rows
        time = rows.time
        mask = (time >= (-1 if low is None else low)) & (time <= (1 << 62 if high is None else high))
        return rows.take(mask)

    def _skipped(self, info: ChunkInfo, problem: BagError) -> None:
        if not self._skip:
            raise BagError(
                f"the chunk at byte {info.pos} cannot be read: {problem}; BagReader(..., skip_damaged=True) "
                "goes on without it, rosproto.bag.recover saves what can be saved",
                path=self.path,
                offset=info.pos,
            ) from problem
        note = f"the chunk at byte {info.pos} is damaged and left out: {problem}"
        if note not in self.damage:
            self.damage.append(note)

    def _decoded(
        self, blob: bytes, conns: list[int], places: Iterable[tuple[int, int, int, int, int]]
    ) -> Iterator[tuple[str, Any, Time]]:
        """The hot loop: decoded messages of one chunk."""
        takers = self._takers(conns)
        time_class, new = Time, object.__new__
        for conn, secs, nsecs, start, end in places:
            stamp = new(time_class)
            stamp.secs = secs
            stamp.nsecs = nsecs
            topic, decode = takers[conn]
            yield topic, decode(blob, start, end), stamp

    def _merged_messages(self, batch: Batch) -> Iterator[tuple[str, Any, Time]]:
        assert batch.pieces is not None
        assert batch.blob_of is not None
        columns = [column.tolist() for column in (batch.pieces, *batch.rows)]
        takers = self._takers(columns[1])
        held, blob = -1, b""
        for piece, conn, secs, nsecs, start, end in zip(*columns, strict=True):
            if piece != held:
                held, blob = piece, batch.blob_of(piece)[1]
            topic, decode = takers[conn]
            yield topic, decode(blob, start, end), Time.from_wire(secs, nsecs)

    def _raw_messages(self, batch: Batch, view: bool) -> Iterator[tuple[str, RawMessage, Time]]:
        columns = [column.tolist() for column in batch.rows]
        if batch.chunk is not None:
            blob = memoryview(batch.chunk.blob) if view else batch.chunk.blob
            base = batch.chunk.base + MESSAGE_HEAD
            yield from self._raw_places(batch.chunk.info, blob, base, zip(*columns, strict=True))
            return
        assert batch.pieces is not None
        assert batch.blob_of is not None
        for piece, place in zip(batch.pieces.tolist(), zip(*columns, strict=True), strict=True):
            info, plain = batch.blob_of(piece)
            yield from self._raw_places(info, memoryview(plain) if view else plain, MESSAGE_HEAD, (place,))

    def _raw_places(
        self,
        info: ChunkInfo,
        blob: bytes | memoryview,
        base: int,
        places: Iterable[tuple[int, int, int, int, int]],
    ) -> Iterator[tuple[str, RawMessage, Time]]:
        """Serialized messages of one chunk."""
        time_class, new, make = Time, object.__new__, tuple.__new__
        facts, pos = self._known, info.pos
        for conn, secs, nsecs, start, end in places:
            stamp = new(time_class)
            stamp.secs = secs
            stamp.nsecs = nsecs
            topic, kind, md5sum, connection = facts[conn]
            place = (pos, start - base)
            yield topic, make(RawMessage, (kind, blob[start:end], md5sum, place, connection)), stamp

    def _raw_found(self, info: ChunkInfo, found: list[Found]) -> Iterator[tuple[str, RawMessage, Time]]:
        facts, pos = self._known, info.pos
        found.reverse()
        while found:  # so that messages already handed out are not kept in memory
            conn, secs, nsecs, offset, data = found.pop()
            topic, kind, md5sum, connection = facts[conn]
            raw = RawMessage(kind, data, md5sum, (pos, offset), connection)
            yield topic, raw, Time.from_wire(secs, nsecs)

    def _takers(self, conns: list[int]) -> dict[int, tuple[str, Give]]:
        """Topic and decoding function for each of these connections."""
        from rosproto.bag.types import decode_function

        takers: dict[int, tuple[str, Give]] = {}
        for conn in set(conns):
            if conn not in self._functions:
                self._functions[conn] = decode_function(self.message_class(self.connections[conn]))
            takers[conn] = self.connections[conn].topic, self._functions[conn]
        return takers


def _as_time(nanoseconds: int) -> Time:
    return Time.from_wire(nanoseconds // NS, nanoseconds % NS)


def _one(index: int) -> NDArray[np.intp]:
    import numpy as np

    return np.array([index], np.intp)
