"""Read ahead: while a chunk's messages are handed out, helper threads decompress the next chunks.

Uncompressed chunks are not read ahead: the operating system already does that, and passing them between
threads would cost more than it saves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import ChunkData, read_chunk, read_small_chunk
from rosproto.bag.compression import keep_freed_memory
from rosproto.bag.helpers import Helpers, Task, helper_count
from rosproto.bag.records import ChunkInfo

__all__ = ["Following", "ReadAhead"]

Following = Callable[[int], Iterable[ChunkInfo]]

MOST_AHEAD_BYTES = 4 << 20  # uncompressed; a larger chunk is read when its turn comes


class ReadAhead:
    """Chunks of one file for one iteration over it.

    Args:
        source: The file.
        spans: Bytes from each chunk's position to the next chunk.
        helpers: Threads; a few more chunks than threads are read ahead. None: as many as processors allow.
    """

    def __init__(self, source: BagFile, spans: dict[int, int], helpers: int | None = None) -> None:
        self._source = source
        self._spans = spans
        helpers = helper_count() if helpers is None else helpers
        self._depth = 2 * helpers + 2 if helpers else 0
        # Daemon threads: what they read is of no use to a program that is ending.
        self._helpers = Helpers("bag reader", helpers, daemon=True)
        self._tasks: dict[int, Task[ChunkData | None]] = {}
        self._packed = False
        keep_freed_memory()

    def take(
        self, info: ChunkInfo, following: Callable[[int], Iterable[ChunkInfo]] | None = None
    ) -> ChunkData:
        """A chunk.

        Args:
            info: The chunk.
            following: Returns that many of the chunks that will be asked for next.

        Raises:
            BagError: It is damaged.
        """
        task = self._tasks.pop(info.pos, None)
        if self._packed and self._depth and following is not None:
            for ahead in following(self._depth):
                if ahead.pos not in self._tasks:
                    self._tasks[ahead.pos] = self._helpers.add(lambda chunk=ahead: self._read_small(chunk))  # type: ignore[misc]
        data = None if task is None else self._helpers.wait(task)
        if data is None:
            data = self._read(info)
        self._packed = data.packed
        return data

    def _read(self, info: ChunkInfo) -> ChunkData:
        return read_chunk(self._source, info, self._spans[info.pos])

    def _read_small(self, info: ChunkInfo) -> ChunkData | None:
        """In any thread: the chunk, or None for a large one."""
        return read_small_chunk(self._source, info, self._spans[info.pos], MOST_AHEAD_BYTES)
