"""The output file of a bag writer: chunks are compressed in parallel and written in order."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from dataclasses import dataclass
from itertools import islice
from typing import BinaryIO

from rosproto.bag.compression import keep_freed_memory
from rosproto.bag.records import ChunkHeader, ChunkInfo
from rosproto.errors import BagError
from rosproto.sentence import say
from rosproto.worker_pool import WorkerPool, worker_count

LARGE = 1 << 16  # bytes; a piece of at least this size is not copied to join it with others
AHEAD_BYTES = 16 << 20  # of chunks not yet written, uncompressed

Piece = bytes | memoryview


class BagOutputFile:
    """A seekable binary file, written by position.

    Args:
        file: Path, or a file object, which stays open when this is closed.
        keep: Open an existing file without emptying it.

    Raises:
        BagError: It cannot be opened.

    Attributes:
        path: The path, None for a file object without a name.
        existed: Whether the file has contents that are to be continued.
    """

    def __init__(self, file: str | os.PathLike[str] | BinaryIO, *, keep: bool) -> None:
        if isinstance(file, (str, os.PathLike)):
            self.path: str | None = os.fspath(file)
            self.existed = keep and os.path.exists(self.path)
            try:
                # Unbuffered: whole chunks are written, a buffer would only copy them once more.
                self.file: BinaryIO = open(self.path, "r+b" if self.existed else "w+b", buffering=0)  # noqa: SIM115
            except OSError as problem:
                raise BagError(
                    say("cannot open the bag for writing: {why}", why=problem.strerror), path=self.path
                ) from problem
            self._owned = True
        else:
            name = getattr(file, "name", None)
            self.path = name if isinstance(name, str) else None
            self.file, self._owned = file, False
            self.existed = keep and file.seek(0, os.SEEK_END) > 0

    def put(self, pieces: Sequence[Piece], at: int) -> int:
        """Write pieces one after the other; returns the position after them.

        Raises:
            OSError: Not all of them are written.
        """
        self.file.seek(at)
        for piece in _gathered(pieces):
            at += len(piece)
            view = memoryview(piece)
            while len(view):  # a raw file may take less than all of it
                view = view[self.file.write(view) or 0 :]
        return at

    def truncate(self, size: int) -> None:
        """Truncate the file to `size` bytes."""
        self.file.truncate(size)

    def close(self) -> None:
        """Close the file if it was opened here."""
        if self._owned:
            self.file.close()


def _gathered(pieces: Sequence[Piece]) -> Iterator[Piece]:
    """Join small pieces; large ones are not copied."""
    small: list[Piece] = []
    for piece in pieces:
        if len(piece) < LARGE:
            small.append(piece)
            continue
        if small:
            yield b"".join(small)
            small = []
        yield piece
    if small:
        yield b"".join(small)


@dataclass(eq=False, slots=True)
class _Chunk:
    """A chunk not yet written."""

    info: ChunkInfo
    size: int
    indexes: bytes
    packed: Future[bytes]


class ChunkWriter:
    """Writes chunks in the order they are given.

    Uncompressed chunks are in the file when `add` returns. Helper threads compress the others; the thread
    that finishes the next chunk in order writes it. At most 16 MB wait (or one chunk, if it is larger).

    Args:
        output: The file.
        compression: "none", "bz2" or "lz4".
        compress: The function that compresses a chunk.

    Attributes:
        end: Position after the last whole chunk; the next one is written there.
        chunks: The chunks in the file; each is added when it has been written.
        messages: Messages in the chunks that were written here.
        problem: The error that ended writing, None while all is well.
    """

    def __init__(self, output: BagOutputFile, compression: str, compress: Callable[[bytes], bytes]) -> None:
        self._output = output
        self.end = 0
        self.chunks: list[ChunkInfo] = []
        self.messages = 0
        self.problem: BaseException | None = None
        self._order: deque[_Chunk] = deque()
        self._bytes = 0
        self._writing = threading.RLock()  # reentrant: a signal handler may close the bag
        # Not daemon threads: a program that ends without closing its bag still writes these chunks.
        self._workers = WorkerPool("rosproto:bag writer", worker_count(), daemon=False, in_caller=True)
        self.set_compression(compression, compress)

    def set_compression(self, compression: str, compress: Callable[[bytes], bytes]) -> None:
        """Set the compression of chunks added from now on."""
        self.drain()
        self._compression, self._compress = compression, compress

    @property
    def size(self) -> int:
        """Bytes in the file, plus the uncompressed bytes of waiting chunks."""
        return self.end + self._bytes

    def add(self, info: ChunkInfo, size: int, parts: Sequence[Piece], indexes: bytes) -> None:
        """Add a chunk; check `problem` afterwards.

        Args:
            info: Its contents; this method sets its position.
            size: Bytes of its data.
            parts: The data; the caller may change it after the call.
            indexes: The index records after the chunk.
        """
        if self._compression == "none":
            self._put(info, size, size, parts, indexes)
            return
        keep_freed_memory()
        plain, compress = b"".join(parts), self._compress
        chunk = _Chunk(info, size, indexes, self._workers.add(lambda: compress(plain)))
        with self._writing:
            self._order.append(chunk)
            self._bytes += size
        chunk.packed.add_done_callback(lambda _: self._write_ready())
        while self._bytes > AHEAD_BYTES:
            self.drain(1)

    def drain(self, limit: int | None = None) -> None:
        """Wait until all added chunks (or the first `limit`) are in the file, or writing has failed."""
        with self._writing:
            first = [chunk.packed for chunk in islice(self._order, limit)]
        wait(first)
        self._write_ready()

    def _write_ready(self) -> None:
        """Write the compressed chunks at the front. Any thread may call it."""
        with self._writing:
            while self._order and self._order[0].packed.done():
                chunk = self._order[0]
                if self.problem is None:
                    self.problem = chunk.packed.exception()
                if self.problem is None:
                    packed = chunk.packed.result()
                    self._put(chunk.info, chunk.size, len(packed), [packed], chunk.indexes)
                if self._order and self._order[0] is chunk:  # unless a signal handler has closed the bag
                    self._order.popleft()
                    self._bytes -= chunk.size

    def _put(self, info: ChunkInfo, size: int, stored: int, parts: Sequence[Piece], indexes: bytes) -> None:
        """Write a chunk and its index records; on failure cut the file back to its last whole chunk."""
        info.pos = self.end
        head = ChunkHeader(self._compression, size).encode(stored)
        try:
            end = self._output.put([head, *parts, indexes], self.end)
        except (OSError, ValueError) as problem:  # ValueError: the file is closed
            self.problem = problem
            try:
                self._output.truncate(self.end)
            except (OSError, ValueError):
                pass  # readers find the last whole chunk anyway
            return
        self.end = end
        if info.counts:
            self.chunks.append(info)
            self.messages += sum(info.counts.values())
