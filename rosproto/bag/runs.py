"""The messages of a bag as runs: rows of messages that lie in one chunk, all of them in the order of time.

Three ways lead through a chunk, whichever is quickest for it: large messages of an uncompressed one are read
one by one, a few messages are found by Python, many by numpy. Chunks that overlap in time are merged.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from rosproto.bag.bag_file import BagFile, Unreachable
from rosproto.bag.chunk import ChunkData, plain_data, read_chunk
from rosproto.bag.large_messages import Found, few_alone, few_messages, few_places
from rosproto.bag.merge import Batch, merge
from rosproto.bag.read_ahead import Following, ReadAhead
from rosproto.bag.records import ChunkInfo
from rosproto.bag.rows import MESSAGE_HEAD, Rows
from rosproto.errors import BagError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Place", "Run", "RunReader"]

Place = tuple[int, int, int, int, int]
"""A message: connection, secs, nsecs, its first byte in the chunk's plain bytes, and the one behind it."""


class Run(NamedTuple):
    """Messages of one chunk, in the order of time; to be gone through once.

    Attributes:
        info: The chunk.
        blob: Its plain bytes; None when the messages were read one by one.
        base: Where its data begins in there.
        places: The messages.
        found: The messages that are read one by one; what was gone through need not be kept there.
        fetch: Reads one of those, by its offset in the chunk and its size; None where the chunk turns out to
            be damaged, which is noted then.
    """

    info: ChunkInfo
    blob: bytes | None
    base: int
    places: Iterable[Place]
    found: list[Found] | None = None
    fetch: Callable[[int, int], bytes | None] | None = None

    def messages(self) -> Iterator[tuple[int, int, int, bytes]]:
        """Connection, secs, nsecs and bytes of each."""
        blob = self.blob
        if blob is None:
            return self._read()
        return ((conn, secs, nsecs, blob[start:end]) for conn, secs, nsecs, start, end in self.places)

    def _read(self) -> Iterator[tuple[int, int, int, bytes]]:
        assert self.found is not None
        assert self.fetch is not None
        for conn, secs, nsecs, offset, size, data in self.found:
            if data is None and (data := self.fetch(offset, size)) is None:
                return
            yield conn, secs, nsecs, data


class RunReader:
    """What a reader does with chunks; the fields are those of `BagReader`."""

    _source: BagFile
    _spans: dict[int, int]
    _skip: bool
    path: str | None
    chunks: tuple[ChunkInfo, ...]
    damage: list[str]
    _lost: bool  # a scan, in place of the index, had to leave messages out

    def runs(
        self, wanted: Collection[int], low: int | None = None, high: int | None = None, *, apart: bool = False
    ) -> Iterator[Run]:
        """All messages of these connections; for callers that need bytes, not objects.

        Args:
            wanted: Ids of connections.
            low: Not earlier than this, ns.
            high: Not later than this, ns.
            apart: A run may be of messages read one by one, where that is quicker.

        Raises:
            BagError: A chunk is damaged, and `skip_damaged` was not asked for.
        """
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
                    yield from runs_of(batch)
                continue
            number += 1
            # Only for a chunk that lies wholly in the span: its messages are not filtered by time below.
            whole = (low is None or info.start >= low) and (high is None or info.end <= high)
            if whole and apart and (run := self._few_messages(info, wanted)) is not None:
                yield run
                continue
            data = self._load(info, ahead, lambda count, at=number: order[at : at + count])  # type: ignore[misc]
            if data is None:
                continue
            places: Sequence[Place] | None = None
            if whole:
                places = few_places(data.blob, data.base, data.end, info.counts)
            if places is None:
                for batch in merge([info], lambda *_, held=data: held, self._selector(wanted, low, high)):
                    yield from runs_of(batch)
                continue
            if not info.counts.keys() <= wanted:  # type: ignore[operator]
                places = [place for place in places if place[0] in wanted]
            yield Run(info, data.blob, data.base, places)
            del data, places  # the next chunk is read into the same memory, still in the cache

    def _alone(self, order: list[ChunkInfo]) -> list[bool]:
        return few_alone(order)

    def _few_messages(self, info: ChunkInfo, wanted: Collection[int]) -> Run | None:
        """A chunk's messages, to be read one by one; None where that is slower, or the chunk is damaged."""
        self._source.check_open()
        if self._source.far:
            return None
        try:
            position, size = plain_data(self._source, info)
            found = few_messages(self._source, info, position, size, wanted) if size else None
        except BagError:
            return None  # the general way reports what is wrong
        return None if found is None else Run(info, None, 0, (), found, self._fetcher(info, position))

    def _fetcher(self, info: ChunkInfo, position: int) -> Callable[[int, int], bytes | None]:
        """What reads messages of a chunk whose data begins at this position of the file."""
        source = self._source
        first = position + MESSAGE_HEAD

        def fetch(offset: int, size: int) -> bytes | None:
            source.check_open()
            try:
                data = source.read_at(first + offset, size)
                if len(data) != size:
                    raise source.error("the file has become shorter", position + offset)
            except BagError as problem:
                self._skipped(info, problem)
                return None
            return data

        return fetch

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


def runs_of(batch: Batch) -> Iterator[Run]:
    """A batch's messages; where they come from several chunks by turns, a run for each turn."""
    import numpy as np

    places = list(zip(*[column.tolist() for column in batch.rows], strict=True))
    if batch.chunk is not None:
        yield Run(batch.chunk.info, batch.chunk.blob, batch.chunk.base, places)
        return
    assert batch.pieces is not None
    assert batch.chunk_of is not None
    turns = [0, *(np.flatnonzero(np.diff(batch.pieces)) + 1).tolist(), len(places)]
    for start, end in pairwise(turns):
        chunk = batch.chunk_of(int(batch.pieces[start]))
        yield Run(chunk.info, chunk.blob, chunk.base, places[start:end])
