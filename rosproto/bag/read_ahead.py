"""Read ahead: helper threads decompress the next chunks while messages of the current one are read.

Uncompressed chunks are not read ahead: the operating system already does that, and passing them between
threads would cost more than it saves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rosproto.bag.chunk import ChunkData
from rosproto.bag.compression import keep_freed_memory
from rosproto.bag.records import ChunkInfo
from rosproto.bag.worker_pool import Task, WorkerPool, worker_count
from rosproto.errors import BagError

BUDGET_BYTES = (
    64 << 20
)  # of the plain bytes of all chunks that are read ahead, and as much as they are stored


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
        self._depth = 2 * helpers + 2 if helpers else 0  # a few more chunks than threads
        self._most = BUDGET_BYTES // max(1, self._depth)  # a larger chunk is not read ahead
        # Daemon threads: a program that ends does not need their results.
        self._workers = WorkerPool("bag reader", helpers, daemon=True)
        self._tasks: dict[int, Task[ChunkData | None]] = {}
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
        data = None if task is None else self._workers.wait(task)
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
                self._tasks[number] = self._workers.add(lambda info=info: self._try(info))  # type: ignore[misc]
        self._begun = max(self._begun, end)

    def _try(self, info: ChunkInfo) -> ChunkData | None:
        """In any thread: read the chunk; None for a large or damaged one, which `take` reads again."""
        try:
            return self._read(info, self._most)
        except BagError:
            return None
