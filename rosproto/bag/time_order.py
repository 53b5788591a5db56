"""The messages of a bag in time order, as runs of messages in one chunk.

Recorders write one chunk after the other, so time spans of chunks rarely overlap, and one chunk at a time is
read, sorted and yielded. Overlapping chunks are opened by start time; before each is opened, all messages up
to its start are yielded. If overlapping chunks exceed the budget, only the places of their messages are kept
(about 50 bytes each), and chunks are read again when messages are due: for at least as many bytes of messages
as the budget, or as the largest chunk has, so that a bag whose chunks all overlap is unpacked at most once
for each 64 MB of its messages. Chunks of bz2 are kept as LZ4 within the budget: bz2 unpacks 30 MB a second,
LZ4 a hundred times as much.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.chunk import ChunkData
from rosproto.bag.compression import compressor, decompress, keep_freed_memory
from rosproto.bag.message_offsets import MessageLocation, MessageTable
from rosproto.bag.records import ChunkInfo
from rosproto.errors import BagError
from rosproto.worker_pool import WorkerPool, worker_count

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


BUDGET_BYTES = 64 << 20  # of chunks in memory that overlap in time, and of messages copied from them
MESSAGE_BYTES = 200  # of a message's place and objects, beside its data


Load = Callable[[int], "ChunkData | None"]
"""Returns the chunk with a number; None for one that is left out."""


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
        offsets: Where each row was in its chunk, (N,) int64, if `chunk_of` gives parts of chunks.
    """

    rows: MessageTable
    chunk: ChunkData | None
    pieces: NDArray[np.int64] | None = None
    chunk_of: Callable[[int], ChunkData] | None = None
    offsets: NDArray[np.int64] | None = None


def merged(
    order: Sequence[ChunkInfo],
    numbers: Sequence[int],
    load: Load,
    select: Callable[[ChunkData], MessageTable | None],
    load_again: Callable[[Sequence[int]], Load],
) -> Iterator[Batch]:
    """Messages of chunks that may overlap, in time order; those of equal time in file order.

    Args:
        order: Chunks by start time.
        numbers: Those to merge: consecutive numbers in the order.
        load: Reads the chunk with a number; None for one that is left out.
        select: Returns a chunk's messages to yield; None to leave it out.
        load_again: Begins to read chunks with these numbers once more, and returns what takes them in this
            order.
    """
    held = ChunkCache(order, load, load_again)
    waiting: list[_PendingMessages] = []
    patience = 0  # chunks until the waiting ones are looked through again: their number may be large
    for number in numbers:
        data = held.load(number)
        rows = None if data is None else select(data)
        if data is not None and rows is not None and len(rows.conn):
            held.put(number, data)
            rows = rows.in_time_order()
            waiting.append(_PendingMessages(number, rows, rows.time, len(data.blob)))
        data = None  # not in memory twice while the next one is read
        limit = order[number + 1].start if number + 1 in numbers else None
        patience -= 1
        if limit is not None and patience > 0:
            continue
        if limit is None or _pays(waiting, limit):
            due, waiting = _release(waiting, limit)
            yield from _batches_of(due, waiting, held)
        patience = len(waiting) // 8


def runs_of(batch: Batch) -> Iterator[ChunkMessages]:
    """Split a batch into runs of messages of one chunk."""
    import numpy as np

    places = batch.rows.places()
    if batch.chunk is not None:
        yield ChunkMessages(batch.chunk.info, batch.chunk.blob, batch.chunk.base, places)
        return
    assert batch.pieces is not None
    assert batch.chunk_of is not None
    if batch.offsets is not None:
        bases = (batch.rows.start - batch.offsets).tolist()
        for number, base, place in zip(batch.pieces.tolist(), bases, places, strict=True):
            part = batch.chunk_of(number)
            yield ChunkMessages(part.info, part.blob, base, (place,))
        return
    turns = [0, *(np.flatnonzero(np.diff(batch.pieces)) + 1).tolist(), len(places)]
    for start, end in pairwise(turns):
        chunk = batch.chunk_of(int(batch.pieces[start]))
        yield ChunkMessages(chunk.info, chunk.blob, chunk.base, places[start:end])


# -- chunks that overlap in time -----------------------------------------------------------------------------


def overlapping(order: Sequence[ChunkInfo]) -> Iterator[range]:
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
    chunk_bytes: int

    def part(self, which: slice) -> _PendingMessages:
        return _PendingMessages(self.number, self.rows.take(which), self.time[which], self.chunk_bytes)


def _pays(waiting: list[_PendingMessages], limit: int) -> bool:
    """Whether messages up to `limit` are to be yielded now: their chunks are in memory, or they are many."""
    if sum(piece.chunk_bytes for piece in waiting) <= BUDGET_BYTES:
        return True
    due = 0
    for piece in waiting:
        due += int(_weights(piece.rows)[: piece.time.searchsorted(limit, "right")].sum())
    return due >= BUDGET_BYTES


def _weights(rows: MessageTable) -> NDArray[np.int64]:
    """The memory that each message takes once it is copied."""
    return rows.end - rows.start + MESSAGE_BYTES


def _release(
    waiting: list[_PendingMessages], limit: int | None
) -> tuple[list[_PendingMessages], list[_PendingMessages]]:
    """All messages up to `limit`, and the remaining ones."""
    import numpy as np

    out: list[_PendingMessages] = []
    left: list[_PendingMessages] = []
    for piece in waiting:
        size = len(piece.time)
        count = size if limit is None else int(np.searchsorted(piece.time, limit, "right"))
        if count:
            out.append(piece.part(slice(count)))
        if count < size:
            left.append(piece.part(slice(count, size)))
    return out, left


def _batches_of(
    due: list[_PendingMessages], waiting: list[_PendingMessages], held: ChunkCache
) -> Iterator[Batch]:
    """The messages that are due, merged; in several batches if their chunks do not fit into memory."""
    import numpy as np

    held.keep_only({piece.number for piece in (*due, *waiting)})
    if not due:
        return
    if len(due) == 1:
        yield Batch(due[0].rows, held.get(due[0].number))
        return
    order = np.argsort(np.concatenate([piece.time for piece in due]), kind="stable")
    rows = MessageTable(
        *[np.concatenate(columns)[order] for columns in zip(*[piece.rows for piece in due], strict=True)]
    )
    pieces = np.concatenate([np.full(len(piece.time), piece.number, np.int64) for piece in due])[order]
    if sum(piece.chunk_bytes for piece in due) <= held.room:
        yield Batch(rows, None, pieces, held.get)
        return
    weight = np.cumsum(_weights(rows))
    # A larger chunk takes more memory in any case. With as much for messages, it is read less often.
    budget = max(BUDGET_BYTES, *(piece.chunk_bytes for piece in due))
    first = 0
    while first < len(pieces):
        maximum = budget + (int(weight[first - 1]) if first else 0)
        end = max(first + 1, int(np.searchsorted(weight, maximum, "right")))
        yield _copied(rows.take(slice(first, end)), pieces[first:end], held)
        first = end


def _copied(rows: MessageTable, pieces: NDArray[np.int64], held: ChunkCache) -> Batch:
    """A batch with copies of its messages, for which each chunk is read once."""
    import numpy as np

    order = np.argsort(pieces, kind="stable")
    numbers, firsts = np.unique(pieces[order], return_index=True)
    if len(numbers) == 1:
        return Batch(rows, held.get(int(numbers[0])))
    parts: dict[int, ChunkData] = {}
    start, end, offsets = np.empty_like(rows.start), np.empty_like(rows.start), np.empty_like(rows.start)
    rows_of = dict(zip(numbers.tolist(), np.split(order, firsts[1:]), strict=True))
    for number, chunk in held.each(rows_of):
        which = rows_of[number]
        first, last = rows.start[which], rows.end[which]
        pairs = zip(first.tolist(), last.tolist(), strict=True)
        blob = b"".join([chunk.blob[from_byte:to_byte] for from_byte, to_byte in pairs])
        end[which] = np.cumsum(last - first)
        start[which] = end[which] - (last - first)
        offsets[which] = first - chunk.base
        parts[number] = ChunkData(chunk.info, blob, 0, len(blob))
        del chunk  # before the next one is read
    return Batch(rows._replace(start=start, end=end), None, pieces, parts.__getitem__, offsets)


class ChunkCache:
    """A cache of the recently used chunks: at most BUDGET_BYTES, but at least one chunk.

    A chunk beyond that is given up before the next one is read; one of bz2 is packed as LZ4 first.

    Attributes:
        held_bytes: Bytes of the chunks that are held, and of those that are packed.
    """

    def __init__(
        self, order: Sequence[ChunkInfo], load: Load, load_again: Callable[[Sequence[int]], Load]
    ) -> None:
        self._order = order
        self._load = load
        self._load_again = load_again
        self._pack = compressor("lz4")
        self._chunks: OrderedDict[int, ChunkData] = OrderedDict()
        self._packed: dict[int, tuple[bytes, ChunkData]] = {}  # as LZ4, and the chunk without its data
        self.held_bytes = 0

    @property
    def room(self) -> int:
        """Bytes of chunks that can be held at a time beside those that are packed."""
        return BUDGET_BYTES - sum(len(packed) for packed, _ in self._packed.values())

    def load(self, number: int) -> ChunkData | None:
        """Read a chunk that is not held."""
        self._give_up(0)
        return self._load(number)

    def _give_up(self, kept: int) -> None:
        while self.held_bytes > BUDGET_BYTES and len(self._chunks) > kept:
            number, data = self._chunks.popitem(last=False)
            self.held_bytes -= len(data.blob)
            if data.compression == "bz2":
                packed = bytes(memoryview(self._pack(data.blob)))  # of its size: the frame has room for more
                self._packed[number] = packed, replace(data, blob=b"", tail=None)
                self.held_bytes += len(packed)
        while (
            self.held_bytes > BUDGET_BYTES and self._packed
        ):  # the newest, so that the others last a whole pass
            self.held_bytes -= len(self._packed.popitem()[1][0])

    def _unpacked(self, number: int) -> ChunkData:
        packed, data = self._packed[number]
        return replace(data, blob=decompress("lz4", packed, data.end))

    def put(self, number: int, data: ChunkData) -> None:
        self._chunks[number] = data
        self.held_bytes += len(data.blob)
        self._give_up(1)

    def each(self, numbers: Iterable[int]) -> Iterator[tuple[int, ChunkData]]:
        """Each of these chunks, first those in memory: in one order, the next pass would find none."""
        known: list[int] = []
        missing: list[int] = []
        for number in numbers:
            (known if number in self._chunks or number in self._packed else missing).append(number)
        for number in known:
            yield number, self._unpacked(number) if number in self._packed else self.get(number)
        load = self._load_again(missing)
        for number in missing:
            yield number, self.get(number, load)

    def get(self, number: int, load: Load | None = None) -> ChunkData:
        data = self._chunks.get(number)
        if data is not None:
            self._chunks.move_to_end(number)
            return data
        self._give_up(0)
        data = self._unpacked(number) if number in self._packed else (load or self._load)(number)
        self.held_bytes -= len(self._packed.pop(number, (b"",))[0])
        if data is None:  # it was readable before
            raise BagError("the bag changed while it was read", offset=self._order[number].pos)
        self.put(number, data)
        return data

    def keep_only(self, numbers: set[int]) -> None:
        for number in [n for n in self._chunks if n not in numbers]:
            self.held_bytes -= len(self._chunks.pop(number).blob)
        for number in [n for n in self._packed if n not in numbers]:
            self.held_bytes -= len(self._packed.pop(number)[0])


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
        beside: Another one of the same file that goes on later; its threads are used.
    """

    def __init__(
        self,
        read: Callable[[ChunkInfo, int | None], ChunkData],
        order: Sequence[ChunkInfo],
        spans: Mapping[int, int],
        *,
        beside: ReadAhead | None = None,
    ) -> None:
        self._read = read
        self._order = order
        self._spans = spans
        helpers = worker_count()
        self._depth = 2 * helpers + 2  # a few more chunks than threads
        # A larger chunk is not read ahead. What another one has read ahead is still in memory.
        self._most = AHEAD_BYTES // self._depth // (1 if beside is None else 4)
        # Daemon threads: a program that ends does not need their results.
        self._workers: WorkerPool = (
            beside._workers
            if beside
            else WorkerPool("rosproto:bag reader", helpers, daemon=True, in_caller=True)
        )
        self._tasks: dict[int, Future[ChunkData | None]] = {}
        self._begun = 0
        self._packed: bool = beside is not None and beside._packed

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
        packed = data.compression != "none"
        if packed and not self._packed:
            self._begin(number + 1)
        self._packed = packed
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
