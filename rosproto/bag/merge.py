"""Merge the messages of many chunks in time order, with as few chunks in memory as possible.

Recorders write one chunk after the other, so their time spans rarely overlap, and one chunk at a time is
read, sorted and handed out. Where spans do overlap, chunks are opened by start time, and before the next one
is opened, all messages up to its start are handed out. If so many chunks overlap that they exceed the budget,
their bytes are dropped, only the places of their messages are kept (28 bytes each), and a chunk is read again
when its messages are due.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.bag.chunk import ChunkData
from rosproto.bag.read_ahead import Following
from rosproto.bag.records import ChunkInfo
from rosproto.bag.rows import Rows
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Batch", "merge"]

BUDGET_BYTES = 64 << 20

Load = Callable[[ChunkInfo, Following | None], "ChunkData | None"]
Select = Callable[[ChunkData], "Rows | None"]


@dataclass(slots=True)
class Batch:
    """Messages in time order.

    Attributes:
        rows: Where they are.
        chunk: The chunk of all of them; None when they come from several.
        pieces: For each row the number of its chunk, (N,) int64; None with one chunk.
        chunk_of: Gives a chunk by that number.
    """

    rows: Rows
    chunk: ChunkData | None
    pieces: NDArray[np.int64] | None = None
    chunk_of: Callable[[int], ChunkData] | None = None


@dataclass(slots=True)
class _Piece:
    """The messages of one chunk that have not been handed out yet, sorted."""

    number: int
    rows: Rows
    time: NDArray[np.int64]


def merge(chunks: Iterable[ChunkInfo], load: Load, select: Select) -> Iterator[Batch]:
    """Batches of messages in time order; messages of equal time in file order.

    Args:
        chunks: The chunks to merge.
        load: Reads a chunk; it gets the chunk and a function that returns the next few. None skips the chunk.
        select: Returns the wanted rows of a chunk in file order; None skips the chunk.
    """
    order = sorted(chunks, key=lambda c: (c.start, c.pos))
    cache = _Cache(order, load)
    waiting: list[_Piece] = []
    for number, info in enumerate(order):
        data = load(info, lambda count, at=number + 1: order[at : at + count])  # type: ignore[misc]
        rows = None if data is None else select(data)
        if data is not None and rows is not None and len(rows.conn):
            cache.put(number, data)
            waiting.append(_sorted_piece(number, rows))
        limit = order[number + 1].start if number + 1 < len(order) else None
        batch, waiting = _release(waiting, limit, cache)
        if batch is not None:
            yield batch


def _sorted_piece(number: int, rows: Rows) -> _Piece:
    import numpy as np

    time = rows.time
    # Checking the order first pays only where sorting takes longer than the check.
    if len(time) < 256 or not _in_order(time, rows.start):
        # By time, then by place in the file: rows come connection by connection.
        order = np.lexsort((rows.start, time))
        return _Piece(number, rows.take(order), time[order])
    return _Piece(number, rows, time)


def _in_order(time: NDArray[np.int64], start: NDArray[np.int64]) -> bool:
    step = time[1:] - time[:-1]
    return bool(((step > 0) | ((step == 0) & (start[1:] > start[:-1]))).all())


def _release(waiting: list[_Piece], limit: int | None, cache: _Cache) -> tuple[Batch | None, list[_Piece]]:
    """Everything up to `limit`, merged, and the pieces left over."""
    import numpy as np

    out: list[_Piece] = []
    left: list[_Piece] = []
    for piece in waiting:
        count = len(piece.time) if limit is None else int(np.searchsorted(piece.time, limit, "right"))
        if count:
            out.append(_slice(piece, 0, count))
        if count < len(piece.time):
            left.append(_slice(piece, count, len(piece.time)))
    if not out:
        return None, left
    cache.keep_only({piece.number for piece in out} | {piece.number for piece in left})
    if len(out) == 1:
        return Batch(out[0].rows, cache.get(out[0].number)), left
    order = np.argsort(np.concatenate([piece.time for piece in out]), kind="stable")
    conn, secs, nsecs, start, end = zip(*[piece.rows for piece in out], strict=True)
    rows = Rows(
        np.concatenate(conn)[order],
        np.concatenate(secs)[order],
        np.concatenate(nsecs)[order],
        np.concatenate(start)[order],
        np.concatenate(end)[order],
    )
    pieces = np.concatenate([np.full(len(piece.time), piece.number, np.int64) for piece in out])[order]
    return Batch(rows, None, pieces, cache.get), left


def _slice(piece: _Piece, start: int, stop: int) -> _Piece:
    if start == 0 and stop == len(piece.time):
        return piece
    conn, secs, nsecs, first, last = piece.rows
    part = slice(start, stop)
    return _Piece(
        piece.number,
        Rows(conn[part], secs[part], nsecs[part], first[part], last[part]),
        piece.time[part],
    )


class _Cache:
    """Chunks in memory, at most BUDGET_BYTES of them (and at least one); the least recently used go first."""

    def __init__(self, order: list[ChunkInfo], load: Load) -> None:
        self._order = order
        self._load = load
        self._held: OrderedDict[int, ChunkData] = OrderedDict()
        self._bytes = 0

    def put(self, number: int, data: ChunkData) -> None:
        self._held[number] = data
        self._bytes += len(data.blob)
        while self._bytes > BUDGET_BYTES and len(self._held) > 1:
            self._bytes -= len(self._held.popitem(last=False)[1].blob)

    def get(self, number: int) -> ChunkData:
        data = self._held.get(number)
        if data is not None:
            self._held.move_to_end(number)
            return data
        data = self._load(self._order[number], None)
        if data is None:  # it was readable a moment ago
            raise BagError("the bag changed while it was read", offset=self._order[number].pos)
        self.put(number, data)
        return data

    def keep_only(self, numbers: set[int]) -> None:
        for number in [n for n in self._held if n not in numbers]:
            self._bytes -= len(self._held.pop(number).blob)
