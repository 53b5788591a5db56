"""The messages of a bag in time order, as runs of messages in one chunk.

Recorders write one chunk after the other, so time spans of chunks rarely overlap, and one chunk at a time is
read, sorted and yielded. Overlapping chunks are opened by start time; before each is opened, all messages up
to its start are yielded. If overlapping chunks exceed the budget, only the places of their messages are kept
(28 bytes each), and a chunk is read again when its messages are due.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.bag_file import BagFile, Unreachable
from rosproto.bag.chunk import ChunkData, read_chunk
from rosproto.bag.compression import keep_freed_memory
from rosproto.bag.message_offsets import MessageLocation, MessageTable
from rosproto.bag.records import ChunkInfo
from rosproto.errors import BagError
from rosproto.worker_pool import WorkerPool, worker_count

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


BUDGET_BYTES = 64 << 20  # of chunks in memory that overlap in time


class ChunkMessages(NamedTuple):
    """Messages of one chunk, in time order.

    Attributes:
        info: The chunk.
        blob: Bytes that contain its uncompressed data.
        base: Offset of the data in `blob`.
        places: Locations of the messages.
    """

    info: ChunkInfo
    blob: bytes
    base: int
    places: Sequence[MessageLocation]


@dataclass(slots=True)
class Batch:
    """Messages in time order.

    Attributes:
        rows: Their locations.
        chunk: Their chunk; None if there are several.
        pieces: For each row the number of its chunk, (N,) int64; None with one chunk.
        chunk_of: Returns a chunk by that number.
    """

    rows: MessageTable
    chunk: ChunkData | None
    pieces: NDArray[np.int64] | None = None
    chunk_of: Callable[[int], ChunkData] | None = None


class TimeOrderedReader:
    """Reads chunks in time order; the fields are those of `BagReader`."""

    _source: BagFile
    _spans: dict[int, int]
    _skip: bool
    path: str | None
    chunks: tuple[ChunkInfo, ...]
    damage: list[str]
    _lost: bool  # a scan, in place of the index, omitted messages

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
        for numbers in _overlapping(order):
            if len(numbers) == 1:
                take = partial(ahead.take, numbers[0])
                run = self._run(order[numbers[0]], take, wanted, low, high)
                if run is not None:
                    yield run
                del run  # the next chunk reuses the memory, still in the cache
                continue
            for batch in self._merged(ahead, numbers, order, wanted, low, high):
                yield from runs_of(batch)

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

    def _batches(self, wanted: Collection[int], low: int | None, high: int | None) -> Iterator[Batch]:
        order = self._chunks_of(wanted, low, high)
        ahead = ReadAhead(self._read_chunk, order, self._spans)
        return self._merged(ahead, range(len(order)), order, wanted, low, high)

    def _merged(
        self,
        ahead: ReadAhead,
        numbers: Sequence[int],
        order: Sequence[ChunkInfo],
        wanted: Collection[int],
        low: int | None,
        high: int | None,
    ) -> Iterator[Batch]:
        """Messages of chunks that may overlap, in time order; those of equal time in file order."""

        def load(number: int) -> ChunkData | None:
            self._source.check_open()
            try:
                return ahead.take(number)
            except BagError as problem:
                self._skipped(order[number], problem)
                return None

        held = _ChunkCache(order, load)
        waiting: list[_PendingMessages] = []
        for number in numbers:
            data = load(number)
            rows = None if data is None else self._select(data, wanted, low, high)
            if data is not None and rows is not None and len(rows.conn):
                held.put(number, data)
                rows = rows.in_time_order()
                waiting.append(_PendingMessages(number, rows, rows.time))
            limit = order[number + 1].start if number + 1 in numbers else None
            batch, waiting = _release(waiting, limit, held)
            if batch is not None:
                yield batch

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

    def _read_chunk(self, info: ChunkInfo, most: int | None = None) -> ChunkData:
        """Read a chunk of at most `most` bytes, in any thread.

        Raises:
            BagError: The chunk is damaged or larger.
        """
        return read_chunk(self._source, info, self._spans[info.pos], most=most)

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
            raise BagError(
                f"the chunk at byte {info.pos} cannot be read: {problem}; BagReader(..., skip_damaged=True) "
                "goes on without it, rosproto.bag.recover saves what can be saved",
                path=self.path,
                offset=info.pos,
            ) from problem
        note = f"the chunk at byte {info.pos} is damaged and left out: {problem}"
        if note not in self.damage:
            self.damage.append(note)


def runs_of(batch: Batch) -> Iterator[ChunkMessages]:
    """Split a batch into runs of messages of one chunk."""
    import numpy as np

    places = batch.rows.places()
    if batch.chunk is not None:
        yield ChunkMessages(batch.chunk.info, batch.chunk.blob, batch.chunk.base, places)
        return
    assert batch.pieces is not None
    assert batch.chunk_of is not None
    turns = [0, *(np.flatnonzero(np.diff(batch.pieces)) + 1).tolist(), len(places)]
    for start, end in pairwise(turns):
        chunk = batch.chunk_of(int(batch.pieces[start]))
        yield ChunkMessages(chunk.info, chunk.blob, chunk.base, places[start:end])


# -- chunks that overlap in time -----------------------------------------------------------------------------


def _overlapping(order: Sequence[ChunkInfo]) -> Iterator[range]:
    """Groups of chunks that must be merged, by their numbers in the order of start time."""
    first, latest = 0, -1
    for number, info in enumerate(order):
        if number > first and info.start >= latest:
            yield range(first, number)
            first = number
        latest = max(latest, info.end)
    if order:
        yield range(first, len(order))


@dataclass(slots=True)
class _PendingMessages:
    """The messages of one chunk that are not yet yielded, in time order."""

    number: int
    rows: MessageTable
    time: NDArray[np.int64]


def _release(
    waiting: list[_PendingMessages], limit: int | None, held: _ChunkCache
) -> tuple[Batch | None, list[_PendingMessages]]:
    """All messages up to `limit`, merged, and the remaining ones."""
    import numpy as np

    out: list[_PendingMessages] = []
    left: list[_PendingMessages] = []
    for piece in waiting:
        size = len(piece.time)
        count = size if limit is None else int(np.searchsorted(piece.time, limit, "right"))
        if count:
            out.append(_PendingMessages(piece.number, piece.rows.take(slice(count)), piece.time[:count]))
        if count < size:
            left.append(
                _PendingMessages(piece.number, piece.rows.take(slice(count, size)), piece.time[count:])
            )
    if not out:
        return None, left
    held.keep_only({piece.number for piece in out} | {piece.number for piece in left})
    if len(out) == 1:
        return Batch(out[0].rows, held.get(out[0].number)), left
    order = np.argsort(np.concatenate([piece.time for piece in out]), kind="stable")
    rows = MessageTable(
        *[np.concatenate(columns)[order] for columns in zip(*[piece.rows for piece in out], strict=True)]
    )
    pieces = np.concatenate([np.full(len(piece.time), piece.number, np.int64) for piece in out])[order]
    return Batch(rows, None, pieces, held.get), left


class _ChunkCache:
    """A cache of the recently used chunks: at most BUDGET_BYTES, but at least one chunk."""

    def __init__(self, order: Sequence[ChunkInfo], load: Callable[[int], ChunkData | None]) -> None:
        self._order = order
        self._load = load
        self._chunks: OrderedDict[int, ChunkData] = OrderedDict()
        self._bytes = 0

    def put(self, number: int, data: ChunkData) -> None:
        self._chunks[number] = data
        self._bytes += len(data.blob)
        while self._bytes > BUDGET_BYTES and len(self._chunks) > 1:
            self._bytes -= len(self._chunks.popitem(last=False)[1].blob)

    def get(self, number: int) -> ChunkData:
        data = self._chunks.get(number)
        if data is not None:
            self._chunks.move_to_end(number)
            return data
        data = self._load(number)
        if data is None:  # it was readable before
            raise BagError("the bag changed while it was read", offset=self._order[number].pos)
        self.put(number, data)
        return data

    def keep_only(self, numbers: set[int]) -> None:
        for number in [n for n in self._chunks if n not in numbers]:
            self._bytes -= len(self._chunks.pop(number).blob)


# -- chunks that are read ahead ------------------------------------------------------------------------------
# Helper threads decompress the next chunks while messages of the current one are read.
#
# Uncompressed chunks are not read ahead: the operating system already does that, and passing them between
# threads would cost more than it saves.


AHEAD_BYTES = 64 << 20  # of the plain bytes of all chunks that are read ahead, and as much as they are stored


class ReadAhead:
    """Chunks of one file for one iteration over it.

    Args:
        read: Reads a chunk, in any thread; raises a BagError for a damaged one, or one of more bytes than its
            second argument (None: any size).
        order: The chunks, in reading order.
        spans: Bytes from a chunk's position to the next chunk, if known.
    """

    def __init__(
        self,
        read: Callable[[ChunkInfo, int | None], ChunkData],
        order: Sequence[ChunkInfo],
        spans: Mapping[int, int],
    ) -> None:
        self._read = read
        self._order = order
        self._spans = spans
        helpers = worker_count()
        self._depth = 2 * helpers + 2  # a few more chunks than threads
        self._most = AHEAD_BYTES // self._depth  # a larger chunk is not read ahead
        # Daemon threads: a program that ends does not need their results.
        self._workers = WorkerPool("rosproto:bag reader", helpers, daemon=True, in_caller=True)
        self._tasks: dict[int, Future[ChunkData | None]] = {}
        self._begun = 0
        self._packed = False

    def take(self, number: int) -> ChunkData:
        """Return the chunk with this number in the order; a chunk taken before is read again.

        Raises:
            BagError: It is damaged.
        """
        task = self._tasks.pop(number, None)
        if self._packed:
            self._begin(number + 1)
        data = None if task is None else task.result()
        if data is None:
            data = self._read(self._order[number], None)
        if data.packed and not self._packed:
            self._begin(number + 1)
        self._packed = data.packed
        keep_freed_memory()
        return data

    def _begin(self, first: int) -> None:
        """Start reading the next chunks from this number on, if not started yet."""
        end = min(first + self._depth, len(self._order))
        for number in range(max(first, self._begun), end):
            info = self._order[number]
            if self._spans.get(info.pos, 0) <= self._most:
                self._tasks[number] = self._workers.add(partial(self._try, info))
        self._begun = max(self._begun, end)

    def _try(self, info: ChunkInfo) -> ChunkData | None:
        """In any thread: read the chunk; None for a large or damaged one, which `take` reads again."""
        try:
            return self._read(info, self._most)
        except BagError:
            return None
