"""Read bags of recorders that were closed properly or crashed."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, BinaryIO, Literal

from rosproto.bag import time_order
from rosproto.bag.bag_file import BagFile, BagLimits, Scanning, Unreachable, system_errors
from rosproto.bag.chunk import ChunkData, UnreadChunk, chunk_header, read_chunk, read_heads, read_index_times
from rosproto.bag.index_section import open_index
from rosproto.bag.inputs import Stamp, to_ns
from rosproto.bag.message_offsets import MESSAGE_HEAD, MessageLocation, MessageTable
from rosproto.bag.messages import Decoders, RawMessage, decoded_messages, message_class_of, raw_messages
from rosproto.bag.records import NS, ChunkInfo, Connection, total_counts
from rosproto.bag.time_order import (
    Batch,
    ChunkMessages,
    Load,
    ReadAhead,
    merged,
    most_open,
    overlapping,
    runs_of,
)
from rosproto.codec import Message
from rosproto.errors import BagError
from rosproto.sentence import say
from rosproto.time import Time

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from pyarrow import RecordBatchReader


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
    scanned record by record; `damage` then lists the damage, and all complete messages can be read.

    Args:
        file: Path, URL (extra `remote`), or a seekable binary file.
        skip_damaged: Skip the rest of a damaged chunk and note that in `damage`, instead of raising.
        limits: Limits on the cost of reading; see `rosproto.bag.BagLimits`.
        scanning: Called from time to time during such a scan with the bytes done and the total.

    Raises:
        BagError: It cannot be opened, is not a bag, is of version 1, or is encrypted.

    Attributes:
        path: Path of the file, None when there is none.
        size: Bytes of the file.
        damage: Descriptions of the file's damage; empty for a sound bag.
        version: Of the format, usually "2.0".
        trailing_bytes: Bytes behind the table of contents. They do not belong to the bag and are ignored.
        indexed: False when the file had no usable table of contents and was scanned.
        connections: All connections with messages, by id.
        topics: `TopicInfo` by topic, sorted.
        message_count: Messages in the bag.
        chunks: Contents of each chunk, in file order.
    """

    trailing_bytes: int = 0
    _random: tuple[ChunkMessages, dict[int, MessageLocation]] | None = None

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO | BagFile,
        *,
        skip_damaged: bool = False,
        limits: BagLimits | None = None,
        scanning: Scanning | None = None,
    ) -> None:
        self._source = file if isinstance(file, BagFile) else BagFile(file, limits, scanning)
        self._skip = skip_damaged
        try:
            with system_errors(self._source.path):
                self._open()
            self._source.searched()
        except BaseException:
            self._source.close()
            raise

    def _open(self) -> None:
        found = open_index(self._source)
        self._spans = found.spans()
        self._take_contents(found.connections, found.chunks, found.damage)
        self._lost = found.lost
        self.version = found.version
        self.trailing_bytes = found.trailing_bytes
        self.indexed = found.closed

    def _take_contents(
        self, connections: dict[int, Connection], chunks: list[ChunkInfo], damage: list[str]
    ) -> None:
        self.path = self._source.path
        self.size = self._source.size
        self.damage = damage
        self.chunks: tuple[ChunkInfo, ...] = tuple(chunks)
        counts = total_counts(chunks)
        self._counts = counts
        self.connections = MappingProxyType({i: c for i, c in sorted(connections.items()) if counts.get(i)})
        self._known = {i: (c.topic, c.type, c.md5sum, c) for i, c in self.connections.items()}
        self._decoders = Decoders(self.connections)
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

        For bags of any size, memory holds one chunk, or the few that overlap in time (and a few more when
        chunks are compressed, because helper threads read ahead). The arrays of a message that makes up
        a quarter of its chunk or more are views of the chunk and keep it in memory as long as they live;
        smaller messages have bytes of their own.

        Args:
            topics: Only these.
            start_time: Earliest receive time: a Time, or seconds.
            end_time: Latest receive time.
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
    ) -> Iterator[tuple[str, Message | RawMessage, Time]]:
        view = raw == "view"
        with system_errors(self.path):
            for run in self.runs(wanted, low, high):
                yield from (
                    raw_messages(run, self._known, view) if raw else decoded_messages(run, self._decoders)
                )
                del run  # the next chunk reuses the memory, still in the cache

    def message_at(self, topic: str, time: Stamp, *, raw: bool = False) -> tuple[str, Any, Time] | None:
        """The latest message on a topic received at or before a time; None when there is none.

        Reads one chunk if chunks do not overlap.
        """
        wanted, limit = self._wanted(topic, None), to_ns(time)
        best: tuple[int, ChunkMessages] | None = None
        chunks = [c for c in self.chunks if c.start <= limit and not wanted.isdisjoint(c.counts)]
        with system_errors(self.path):
            # By the latest message each may have, the latest first: usually the first chunk has it.
            for info in sorted(chunks, key=lambda c: (min(c.end, limit), c.pos), reverse=True):
                if best is not None and info.end < best[0]:
                    break
                run = self._run(info, partial(self._read_chunk, info), wanted, None, limit)
                if run is not None and run.places:
                    _, secs, nsecs, *_ = run.places[-1]
                    if best is None or secs * NS + nsecs > best[0]:
                        best = secs * NS + nsecs, run._replace(places=run.places[-1:])
            if best is None:
                return None
            run = best[1]
            return next(
                raw_messages(run, self._known, False) if raw else decoded_messages(run, self._decoders)
            )

    def message_from(self, position: tuple[int, int]) -> tuple[str, RawMessage, Time]:
        """The message at a `RawMessage.position`, not decoded; the chunk read last is kept for the next call.

        Raises:
            BagError: There is no message, or its chunk is damaged.
        """
        pos, offset = position
        with system_errors(self.path):
            self._source.check_open()
            if self._random is None or self._random[0].info.pos != pos:
                info = next((chunk for chunk in self.chunks if chunk.pos == pos), None)
                run = info and self._run(info, partial(self._read_chunk, info), self.connections, None, None)
                if not run:
                    raise self._source.error("no readable chunk is here", pos)
                self._random = run, {place[3] - run.base - MESSAGE_HEAD: place for place in run.places}
            run, places = self._random
            if offset not in places:
                raise self._source.error(f"no message is at byte {offset} of the chunk here", pos)
            return next(raw_messages(run._replace(places=(places[offset],)), self._known, False))

    def times(self, topic: str, *, step: Callable[[], None] | None = None) -> NDArray[np.int64]:
        """Receive times of a topic's messages, ns, sorted, (N,) int64; reads index records, not messages.

        `step` is called after each chunk with such messages.
        """
        wanted = self._wanted(topic, None)
        with system_errors(self.path):
            import numpy as np

            parts: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
            for info in self.chunks:
                if wanted.isdisjoint(info.counts):
                    continue
                times = self._index_times(info, wanted)
                if times is None:
                    found = self._rows(info, wanted)
                    times = parts[0] if found is None else found.time
                parts.append(times)
                if step is not None:
                    step()
            return np.sort(np.concatenate(parts))

    def _index_times(self, info: ChunkInfo, wanted: Collection[int]) -> NDArray[np.int64] | None:
        """Times from the chunk's index records; None if there are no usable ones."""
        return read_index_times(self._source, info, self._spans[info.pos], wanted)

    def index_damage(self) -> list[str]:
        """Return a sentence for each chunk whose header or index records are damaged.

        Its messages are often read all the same; rosbag does not open such a bag.
        """
        return [
            f"the index records of the chunk at byte {info.pos} are damaged: rosbag does not open such a bag"
            for info in self.chunks
            if info.indexed and not info.partial and self._index_times(info, info.counts) is None
        ]

    def frequency(self, topic: str, *, step: Callable[[], None] | None = None) -> float | None:
        """Messages per second: one over the median interval, as in rosbag; None below two messages.

        `step` is called as by `times`.
        """
        import numpy as np

        times = self.times(topic, step=step)
        if len(times) < 2:
            return None
        stamps = times // NS + times % NS / NS  # float seconds, as by rosbag
        period = float(np.median(np.diff(stamps)))
        return 1.0 / period if period > 0 else None

    def compression(self, *, step: Callable[[], None] | None = None) -> dict[str, Compression]:
        """How the chunks are compressed, by "none", "bz2", "lz4" and "zstd"; reads a bag's chunk headers.

        `step` is called after each chunk.
        """
        kinds: dict[str, Compression] = {}
        for info in self.chunks:
            name, stored, plain = self._compression_of(info)
            was = kinds.get(name, Compression(0, 0, 0))
            kinds[name] = Compression(was.chunks + 1, was.stored_bytes + stored, was.plain_bytes + plain)
            if step is not None:
                step()
        return kinds

    def _compression_of(self, info: ChunkInfo) -> tuple[str, int, int]:
        """A chunk's compression, its bytes in the file and uncompressed."""
        head, stored = chunk_header(self._source, info)
        return head.compression, stored, head.size or stored

    def message_class(self, which: str | Connection) -> type[Message]:
        """The class that messages of a topic (its first connection) or of a connection are decoded to.

        Raises:
            BagError: No such topic, or no usable definition.
        """
        if isinstance(which, str):
            which = self._topic(which).connections[0]
        return message_class_of(which)

    def to_numpy(self, topic: str, fields: Iterable[str]) -> dict[str, NDArray[Any]]:
        """Columns of a topic: see `rosproto.bag.columns.to_numpy`.

        Raises:
            BagError: No such topic, or no such field; the message lists the existing ones.
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
    ) -> RecordBatchReader:
        """A topic as a `pyarrow.RecordBatchReader`: batches of bounded size, read on demand.

        `.read_all()` makes a Table of it, `.read_pandas()` a DataFrame, and `polars.from_arrow` takes that
        Table. Needs the extra `arrow`. `rosproto.bag.arrow.schema_of` describes the columns.

        Args:
            topic: The topic; all its messages must have the same definition.
            fields: Paths such as "pose.pose.position.x", each a column; None for the whole message. Other
                fields are not decoded.
            start_time: Earliest receive time: a Time, or seconds.
            end_time: Latest receive time.

        Raises:
            BagError: No such topic or field, several definitions, or no pyarrow. While batches are read, the
                errors of `read_messages`, which pyarrow passes on unchanged.
        """
        from rosproto.bag.arrow import to_arrow

        self._topic(topic)
        return to_arrow(self, topic, fields, start_time, end_time)

    def runs(
        self, wanted: Collection[int], low: int | None = None, high: int | None = None
    ) -> Iterator[ChunkMessages]:
        """All messages of these connections, for callers that need bytes, not objects.

        Args:
            wanted: Ids of connections.
            low: Earliest receive time, ns.
            high: Latest receive time, ns.

        Raises:
            BagError: A chunk is damaged, and `skip_damaged` is false.
        """
        order = self._chunks_of(wanted, low, high)
        ahead = ReadAhead(self._read_chunk, order, self._spans)
        for numbers in overlapping(order):
            if len(numbers) == 1:
                take = partial(ahead.take, numbers[0])
                run = self._run(order[numbers[0]], take, wanted, low, high)
                if run is not None:
                    yield run
                del run  # the next chunk reuses the memory, still in the cache
                continue
            for batch in self._merged(ahead, numbers, order, wanted, low, high):
                yield from runs_of(batch)

    def batches(self, topic: str) -> Iterator[Batch]:
        """Locations of a topic's messages, chunk by chunk, for callers that need bytes, not objects.

        Raises:
            BagError: A chunk is damaged (see `skip_damaged`).
        """
        wanted = self._wanted(topic, None)
        order = self._chunks_of(wanted, None, None)
        ahead = ReadAhead(self._read_chunk, order, self._spans)
        return self._merged(ahead, range(len(order)), order, wanted, None, None)

    def _run(
        self,
        info: ChunkInfo,
        read: Callable[[], ChunkData],
        wanted: Collection[int],
        low: int | None,
        high: int | None,
    ) -> ChunkMessages | None:
        """The messages of a chunk, in time order; None if it is damaged and skipped."""
        self._source.check_open()
        try:
            data = read()
            places = data.places(wanted, low, high)
        except BagError as problem:
            self._skipped(info, problem)
            return None
        return ChunkMessages(data.info, data.blob, data.base, places)

    def _merged(
        self,
        ahead: ReadAhead,
        numbers: Sequence[int],
        order: Sequence[ChunkInfo],
        wanted: Collection[int],
        low: int | None,
        high: int | None,
    ) -> Iterator[Batch]:
        def load(number: int, source: ReadAhead = ahead, place: int | None = None) -> ChunkData | None:
            self._source.check_open()
            try:
                return source.take(number if place is None else place)
            except BagError as problem:
                self._skipped(order[number], problem)
                return None

        def load_again(numbers: Sequence[int]) -> Load:
            chosen = [order[number] for number in numbers]
            again, place = ReadAhead(self._read_chunk, chosen, self._spans, beside=ahead), count()
            return lambda number: load(number, again, next(place))

        def unread(number: int) -> UnreadChunk | None:
            self._source.check_open()
            info = order[number]
            found = read_heads(self._source, info, self._spans[info.pos], wanted) if many else None
            return found and found._replace(rows=found.rows.between(low, high))

        def select(data: ChunkData) -> MessageTable | None:
            return self._select(data, wanted, low, high)

        # Chunks that fit into memory are read whole, and so are those of which each read is a round trip.
        overlap = most_open([order[number] for number in numbers], self._spans)
        many = overlap > time_order.BUDGET_BYTES and not self._source.far
        return merged(order, numbers, load, select, load_again, unread)

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

    def _read_chunk(self, info: ChunkInfo, max_bytes: int | None = None) -> ChunkData:
        """Read a chunk of at most `max_bytes` bytes, in any thread.

        Raises:
            BagError: The chunk is damaged or larger.
        """
        return read_chunk(self._source, info, self._spans[info.pos], max_bytes=max_bytes)

    def _rows(self, info: ChunkInfo, wanted: Collection[int]) -> MessageTable | None:
        """A chunk's wanted messages; None if it is damaged and skipped."""
        self._source.check_open()
        try:
            data = self._read_chunk(info)
        except BagError as problem:
            self._skipped(info, problem)
            return None
        return self._select(data, wanted, None, None)

    def _select(
        self, data: ChunkData, wanted: Collection[int], low: int | None, high: int | None
    ) -> MessageTable | None:
        try:
            return data.rows(wanted).between(low, high)
        except BagError as problem:
            self._skipped(data.info, problem)
            return None

    def _skipped(self, info: ChunkInfo, problem: BagError) -> None:
        if isinstance(problem, Unreachable):
            raise problem
        if not self._skip:
            text = (
                "the chunk at byte {at} cannot be read: {error}; `rosproto bag fix` saves what can be saved, "
                "BagReader(..., skip_damaged=True) goes on without it"
            )
            text = say(text, at=info.pos, error=problem)
            raise BagError(text, path=self.path, offset=info.pos) from problem
        note = say("the chunk at byte {at} is damaged and left out: {error}", at=info.pos, error=problem)
        if note not in self.damage:
            self.damage.append(note)

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


def _as_time(nanoseconds: int) -> Time:
    return Time.from_wire(nanoseconds // NS, nanoseconds % NS)
