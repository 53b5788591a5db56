"""The messages of a bag in time order, as runs of messages in one chunk.

Recorders write one chunk after the other, so time spans of chunks rarely overlap, and one chunk at a time is
read, sorted and yielded. Overlapping chunks are opened by start time; before each is opened, all messages up
to its start are yielded. If overlapping chunks exceed the budget, the one used longest ago is given up: the
places of its messages are kept (about 50 bytes each), and copies of those that are among the earliest, within
a second budget. When these are yielded, chunks are read again: for at least as many bytes of messages as the
budget, or as the largest chunk has, so that a bag whose chunks all overlap is unpacked at most once for each
64 MB of its messages. Chunks of bz2 are kept as LZ4 within the budget: bz2 unpacks 30 MB a second, LZ4 a
hundred times as much. Large messages of uncompressed chunks are read one by one instead (`read_heads`): for
64 MB of messages that are due, in the order of the file.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial
from heapq import heappop, heappush
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.chunk import ChunkData, UnreadChunk
from rosproto.bag.compression import compressor, decompress, keep_freed_memory
from rosproto.bag.message_offsets import MessageLocation, MessageTable
from rosproto.bag.records import ChunkInfo
from rosproto.errors import BagError
from rosproto.worker_pool import WorkerPool, worker_count

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


_EVER = 1 << 62  # later than every stamp
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
        single: Messages that have been read one by one, by row.
    """

    rows: MessageTable
    chunk: ChunkData | None
    pieces: NDArray[np.int64] | None = None
    chunk_of: Callable[[int], ChunkData] | None = None
    offsets: NDArray[np.int64] | None = None
    single: dict[int, bytes] = field(default_factory=dict)


def merged(
    order: Sequence[ChunkInfo],
    numbers: Sequence[int],
    load: Load,
    select: Callable[[ChunkData], MessageTable | None],
    load_again: Callable[[Sequence[int]], Load],
    unread: Callable[[int], UnreadChunk | None],
) -> Iterator[Batch]:
    """Messages of chunks that may overlap, in time order; those of equal time in file order.

    Args:
        order: Chunks by start time.
        numbers: Those to merge: consecutive numbers in the order.
        load: Reads the chunk with a number; None for one that is left out.
        select: Returns a chunk's messages to yield; None to leave it out.
        load_again: Begins to read chunks with these numbers once more, and returns what takes them in this
            order.
        unread: Returns a chunk of which messages are read when they are due; None if it is to be loaded.
    """
    waiting = _Waiting()
    held = ChunkCache(order, load, load_again, waiting.copy)
    patience = 0  # chunks until the waiting ones are looked through again: their number may be large
    for number in numbers:
        found = unread(number)
        if found is not None and len(found.rows.conn):
            table = found.rows.in_time_order()
            waiting.pieces[number] = _PendingMessages(number, table, table.time, 0, 0, found.read)
        data = held.load(number) if found is None else None
        rows = None if data is None else select(data)
        if data is not None and rows is not None and len(rows.conn):
            rows = rows.in_time_order()
            waiting.pieces[number] = _PendingMessages(number, rows, rows.time, data.base, len(data.blob))
            held.put(number, data)
        data = None  # not in memory twice while the next one is read
        limit = order[number + 1].start if number + 1 in numbers else None
        patience -= 1
        if limit is not None and patience > 0:
            continue
        if limit is None or waiting.pays(limit):
            yield from _batches_of(waiting.release(limit, held), waiting.pieces, held)
        patience = len(waiting.pieces) // 8


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
        for row, (number, base, place) in enumerate(zip(batch.pieces.tolist(), bases, places, strict=True)):
            part = batch.chunk_of(number)
            yield ChunkMessages(part.info, batch.single.pop(row, part.blob), base, (place,))
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


def most_open(order: Sequence[ChunkInfo], spans: Mapping[int, int]) -> int:
    """The most bytes in the file of chunks that overlap at one time; `order` and `spans` as of ReadAhead."""
    unended: list[tuple[int, int]] = []  # end and bytes
    size = most = 0
    for info in order:
        while unended and unended[0][0] < info.start:
            size -= heappop(unended)[1]
        heappush(unended, (info.end, spans.get(info.pos, 0)))
        size += spans.get(info.pos, 0)
        most = max(most, size)
    return most


@dataclass(slots=True)
class _PendingMessages:
    """The messages of one chunk that are not yet yielded, in time order.

    The first `copied` of them are also in `copies`, one after the other from `first` on. With `read`, which
    reads single messages, the chunk is never loaded.
    """

    number: int
    rows: MessageTable
    time: NDArray[np.int64]
    base: int
    chunk_bytes: int
    read: Callable[[int, int], bytes] | None = None
    copies: bytes = b""
    copied: int = 0
    first: int = 0

    def part(self, start: int, end: int) -> _PendingMessages:
        which = slice(start, end)
        copied = max(0, min(end, self.copied) - start)
        return _PendingMessages(
            self.number,
            self.rows.take(which),
            self.time[which],
            self.base,
            self.chunk_bytes,
            self.read,
            self.copies if copied else b"",
            copied,
            self.first + self.size(min(start, self.copied)),
        )

    def size(self, count: int) -> int:
        """Bytes of the first messages."""
        return int((self.rows.end[:count] - self.rows.start[:count]).sum())


class _Waiting:
    """Messages that are not yet yielded, and copies of the earliest of those whose chunks were given up.

    Attributes:
        pieces: By the number of their chunk.
    """

    def __init__(self) -> None:
        self.pieces: dict[int, _PendingMessages] = {}
        self._until = _EVER  # every message up to this time is in memory
        self._copied = 0  # bytes

    def copy(self, number: int, data: ChunkData) -> None:
        """Copy the wanted messages of a chunk that is given up, as far as they are among the earliest."""
        piece = self.pieces.get(number)
        if piece is None:
            return
        over = int(_weights(piece.rows).cumsum().searchsorted(BUDGET_BYTES, "right"))
        if over < len(piece.time):
            self._until = min(self._until, int(piece.time[over]) - 1)
        count = int(piece.time.searchsorted(self._until, "right"))
        if count <= piece.copied:
            return
        pairs = zip(piece.rows.start[:count].tolist(), piece.rows.end[:count].tolist(), strict=True)
        piece.copies = b"".join([data.blob[start:end] for start, end in pairs])
        piece.copied, piece.first = count, 0
        self._copied += len(piece.copies) + count * MESSAGE_BYTES
        if self._copied > BUDGET_BYTES:
            self._give_up()

    def _give_up(self) -> None:
        """Give up a quarter of the copies, the latest."""
        import numpy as np

        pieces = [piece for piece in self.pieces.values() if piece.copied]
        time = np.concatenate([piece.time[: piece.copied] for piece in pieces])
        weights = np.concatenate([_weights(piece.rows)[: piece.copied] for piece in pieces])
        order = np.argsort(time, kind="stable")
        over = int(weights[order].cumsum().searchsorted(BUDGET_BYTES // 4 * 3, "right"))
        if over < len(order):
            self._until = int(time[order[over]]) - 1
        for piece in pieces:
            piece.copied = min(piece.copied, int(piece.time.searchsorted(self._until, "right")))
            piece.copies = piece.copies[piece.first : piece.first + piece.size(piece.copied)]
            piece.first = 0
        self._count()

    def _count(self) -> None:
        self._copied = sum(len(p.copies) + p.copied * MESSAGE_BYTES for p in self.pieces.values())

    def pays(self, limit: int) -> bool:
        """Whether messages up to `limit` are to be yielded now: they are in memory, or they are many."""
        pieces = self.pieces.values()
        if limit <= self._until or sum(piece.chunk_bytes for piece in pieces) <= BUDGET_BYTES:
            return True
        due = 0
        for piece in pieces:
            due += int(_weights(piece.rows)[: piece.time.searchsorted(limit, "right")].sum())
        return due >= BUDGET_BYTES

    def release(self, limit: int | None, held: ChunkCache) -> list[_PendingMessages]:
        """Take all messages up to `limit` out."""
        out: list[_PendingMessages] = []
        left: dict[int, _PendingMessages] = {}
        for number, piece in self.pieces.items():
            size = len(piece.time)
            count = size if limit is None else int(piece.time.searchsorted(limit, "right"))
            if count:
                out.append(piece.part(0, count))
            if count < size:
                left[number] = piece.part(count, size) if count else piece
        self.pieces = left
        if self._copied:
            self._count()
        if self._until < _EVER and all(
            p.read or p.copied == len(p.time) or held.has(p.number) for p in left.values()
        ):
            self._until = _EVER
        return out


def _weights(rows: MessageTable) -> NDArray[np.int64]:
    """The memory that each message takes once it is copied."""
    return rows.end - rows.start + MESSAGE_BYTES


def _batches_of(due: list[_PendingMessages], waiting: Collection[int], held: ChunkCache) -> Iterator[Batch]:
    """The messages that are due, merged; in several batches if their chunks do not fit into memory."""
    import numpy as np

    held.keep_only({piece.number for piece in due}.union(waiting))
    if not due:
        return
    apart = any(piece.copied or piece.read for piece in due)
    if len(due) == 1 and not apart:
        yield Batch(due[0].rows, held.get(due[0].number))
        return
    order = np.argsort(np.concatenate([piece.time for piece in due]), kind="stable")
    rows = MessageTable(
        *[np.concatenate(columns)[order] for columns in zip(*[piece.rows for piece in due], strict=True)]
    )
    pieces = np.concatenate([np.full(len(piece.time), piece.number, np.int64) for piece in due])[order]
    if not apart and sum(piece.chunk_bytes for piece in due) <= held.room:
        yield Batch(rows, None, pieces, held.get)
        return
    # First those in memory, then the copies are not needed any more.
    ready = [
        np.arange(len(piece.time)) < (len(piece.time) if held.has(piece.number) else piece.copied)
        for piece in due
    ]
    first = int(np.append(np.concatenate(ready)[order], False).argmin())
    for start in range(0, first, at_once := max(1, BUDGET_BYTES // MESSAGE_BYTES)):
        which = slice(start, min(start + at_once, first))
        yield _gathered(rows.take(which), pieces[which], held, due)
    for piece in due:
        piece.copies, piece.copied = b"", 0
    # A larger chunk takes more memory in any case. With as much for messages, it is read less often.
    keep_freed_memory()
    budget = max(BUDGET_BYTES, *(piece.chunk_bytes for piece in due))
    while first < len(pieces):
        held.make_room()
        rest = rows.take(slice(first, None))
        weight = np.where(np.isin(pieces[first:], held.numbers()), MESSAGE_BYTES, _weights(rest)).cumsum()
        count = max(1, int(weight.searchsorted(budget, "right")))
        yield _gathered(rest.take(slice(count)), pieces[first : first + count], held, due)
        first += count


def _gathered(
    rows: MessageTable, pieces: NDArray[np.int64], held: ChunkCache, due: list[_PendingMessages]
) -> Batch:
    """A batch of chunks in memory and of copies; chunks of which there are neither are read for it, once."""
    import numpy as np

    order = np.argsort(pieces, kind="stable")
    numbers, firsts = np.unique(pieces[order], return_index=True)
    piece_of = {piece.number: piece for piece in due}
    rows_of = dict(zip(numbers.tolist(), np.split(order, firsts[1:]), strict=True))
    parts: dict[int, ChunkData] = {}
    start, end, offsets = rows.start.copy(), rows.end.copy(), rows.start.copy()

    def places(number: int) -> Iterator[tuple[int, int]]:
        which = rows_of[number]
        return zip(start[which].tolist(), end[which].tolist(), strict=True)

    def take(number: int, blob: bytes, first: int = 0) -> None:
        """Have the messages of a chunk in `blob`, one after the other."""
        which = rows_of[number]
        size = end[which] - start[which]
        end[which] = first + size.cumsum()
        start[which] = end[which] - size
        parts[number] = ChunkData(held.info(number), blob, 0, len(blob))

    missing: list[int] = []
    single: dict[int, bytes] = {}
    for number, which in rows_of.items():
        piece = piece_of[number]
        offsets[which] -= piece.base
        if held.has(number):
            parts[number] = held.get(number)
        elif piece.copied:
            take(number, piece.copies, piece.first)
            piece.first = int(end[which[-1]])
        elif piece.read:
            parts[number] = ChunkData(held.info(number), b"", 0, 0)
            for row in which[start[which].argsort()].tolist():
                single[row] = piece.read(int(start[row]), int(end[row]))
                start[row], end[row] = 0, len(single[row])
        else:
            missing.append(number)
    for number, chunk in held.each(missing):
        if held.has(number):
            parts[number] = chunk
        else:
            take(number, b"".join([chunk.blob[first:last] for first, last in places(number)]))
        del chunk  # before the next one is read
    return Batch(rows._replace(start=start, end=end), None, pieces, parts.__getitem__, offsets, single)


class ChunkCache:
    """A cache of the recently used chunks: at most BUDGET_BYTES, but at least one chunk.

    A chunk beyond that is given up before the next one is read; one of bz2 is packed as LZ4 first.

    Attributes:
        held_bytes: Bytes of the chunks that are held, and of those that are packed.
    """

    def __init__(
        self,
        order: Sequence[ChunkInfo],
        load: Load,
        load_again: Callable[[Sequence[int]], Load],
        given_up: Callable[[int, ChunkData], None],
    ) -> None:
        self._order = order
        self._load = load
        self._load_again = load_again
        self._given_up = given_up  # called with each chunk that is
        self._pack = compressor("lz4")
        self._chunks: OrderedDict[int, ChunkData] = OrderedDict()
        self._packed: dict[int, tuple[bytes, ChunkData]] = {}  # as LZ4, and the chunk without its data
        self.held_bytes = 0

    def has(self, number: int) -> bool:
        """Whether a chunk is in memory, unpacked."""
        return number in self._chunks

    def numbers(self) -> list[int]:
        """Numbers of such chunks."""
        return list(self._chunks)

    def info(self, number: int) -> ChunkInfo:
        """The chunk with a number."""
        return self._order[number]

    @property
    def room(self) -> int:
        """Bytes of chunks that can be held at a time beside those that are packed."""
        return BUDGET_BYTES - sum(len(packed) for packed, _ in self._packed.values())

    def load(self, number: int) -> ChunkData | None:
        """Read a chunk that is not held."""
        self.make_room()
        return self._load(number)

    def make_room(self, kept: int = 0) -> None:
        """Give chunks up, the least recently used first, until the others are within the budget."""
        while self.held_bytes > BUDGET_BYTES and len(self._chunks) > kept:
            number, data = self._chunks.popitem(last=False)
            self.held_bytes -= len(data.blob)
            self._given_up(number, data)
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
        self.make_room(1)

    def each(self, numbers: Iterable[int]) -> Iterator[tuple[int, ChunkData]]:
        """Each of these chunks, which are not held unpacked; they are kept as far as there is room."""
        missing: list[int] = []
        for number in numbers:
            if number in self._packed:
                yield number, self._unpacked(number)
            else:
                missing.append(number)
        load = self._load_again(missing)
        for number in missing:
            data = self._read(number, load)
            if self.held_bytes + len(data.blob) <= BUDGET_BYTES:
                self.put(number, data)
            yield number, data
            del data

    def get(self, number: int) -> ChunkData:
        data = self._chunks.get(number)
        if data is not None:
            self._chunks.move_to_end(number)
            return data
        self.make_room()
        data = self._unpacked(number) if number in self._packed else self._read(number, self._load)
        self.held_bytes -= len(self._packed.pop(number, (b"",))[0])
        self.put(number, data)
        return data

    def _read(self, number: int, load: Load) -> ChunkData:
        data = load(number)
        if data is None:  # it was readable before
            raise BagError("the bag changed while it was read", offset=self._order[number].pos)
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
