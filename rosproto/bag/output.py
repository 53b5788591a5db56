"""The output file of a bag writer: chunks are compressed in parallel and written in order."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import BinaryIO

from rosproto.bag.compression import keep_freed_memory
from rosproto.bag.records import ChunkHeader, ChunkInfo
from rosproto.bag.worker_pool import WorkerPool, worker_count
from rosproto.errors import BagError

LARGE = 1 << 16  # bytes; a piece of at least this size is not copied to join it with others
_SMALL = 1 << 16  # bytes; a smaller chunk is not worth a thread
AHEAD_BYTES = 16 << 20  # of chunks not yet written, uncompressed
_MOST_PIECES = 512  # in one system call; POSIX promises 16, Linux and the BSDs take 1024

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
        self._writev: Callable[[int, list[Piece]], int] | None = None
        if isinstance(file, (str, os.PathLike)):
            self.path: str | None = os.fspath(file)
            self.existed = keep and os.path.exists(self.path)
            try:
                # Unbuffered: whole chunks are written, a buffer would only copy them once more.
                self.file: BinaryIO = open(self.path, "r+b" if self.existed else "w+b", buffering=0)  # noqa: SIM115
            except OSError as problem:
                raise BagError(
                    f"cannot open the bag for writing: {problem.strerror}", path=self.path
                ) from problem
            self._owned = True
            self._writev = getattr(os, "writev", None)  # not on Windows
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
        gathered = list(_gathered(pieces))
        for first in range(0, len(gathered), _MOST_PIECES):
            some = gathered[first : first + _MOST_PIECES]
            done = self._writev(self.file.fileno(), some) if self._writev and len(some) > 1 else 0
            for piece in some:
                size = len(piece)
                if done < size:
                    self._put_rest(memoryview(piece)[done:])
                done = max(0, done - size)
                at += size
        return at

    def truncate(self, size: int) -> None:
        """Truncate the file to `size` bytes."""
        self.file.truncate(size)

    def close(self) -> None:
        """Close the file if it was opened here."""
        if self._owned:
            self.file.close()

    def _put_rest(self, view: memoryview) -> None:
        while len(view):  # a raw file may take less than all of it
            view = view[self.file.write(view) or 0 :]


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


@dataclass(slots=True)
class _Chunk:
    """A chunk not yet written; `ahead` is its share of the waiting bytes."""

    info: ChunkInfo
    plain: bytes
    indexes: bytes
    ahead: int = 0
    packed: bytes | None = None
    problem: Exception | None = None


class ChunkWriter:
    """Writes chunks in the order they are given.

    Uncompressed chunks are in the file when `add` returns. Helper threads compress the others; the thread
    that finishes the next chunk in order writes it. At most 16 MB wait (or one chunk, if it is larger);
    beyond that `add` does part of the work.

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
        self.problem: Exception | None = None
        self._order: deque[_Chunk] = deque()
        self._bytes = 0
        self._writing = threading.Lock()
        self._moved = threading.Condition()
        # Not daemon threads: a program that ends without closing its bag still writes these chunks.
        self._workers = WorkerPool("bag writer", worker_count(), daemon=False)
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
        chunk = _Chunk(info, b"".join(parts), indexes)
        if size < _SMALL:
            self.drain()
            self._order.append(chunk)
            self._pack(chunk)
            return
        self._order.append(chunk)
        chunk.ahead = size
        with self._moved:
            self._bytes += size
        self._workers.add(lambda: self._pack(chunk))
        while self._order and (self._bytes > AHEAD_BYTES or self._workers.idle):
            self._advance()

    def drain(self) -> None:
        """Wait until all added chunks are in the file, or writing has failed."""
        while self._order:
            self._advance()

    def _advance(self) -> None:
        """Compress a waiting chunk, or wait until another chunk is written."""
        head = self._head()
        if head is None or self._workers.help():
            return
        # A helper has started it. The helper finishes or fails; both end this wait.
        with self._moved:
            self._moved.wait_for(lambda: not self._order or self._order[0] is not head)

    def _pack(self, chunk: _Chunk) -> None:
        """Compress a chunk and write all chunks that are ready. Any thread may call it."""
        if chunk.packed is None:  # otherwise Ctrl-C came between the two steps
            try:
                chunk.packed = self._compress(chunk.plain)
            except Exception as problem:
                chunk.problem, chunk.packed = problem, b""
        while self._is_ready() and self._writing.acquire(blocking=False):
            try:
                self._write_ready()
            finally:
                self._writing.release()
            # Look once more: another chunk may have become ready just before the lock was released.

    def _head(self) -> _Chunk | None:
        """The next chunk to write; another thread may remove it at any time."""
        try:
            return self._order[0]
        except IndexError:
            return None

    def _is_ready(self) -> bool:
        head = self._head()
        return head is not None and head.packed is not None

    def _write_ready(self) -> None:
        """Called with the lock held: no other thread removes chunks."""
        while self._is_ready():
            chunk = self._order[0]
            if self.problem is None:
                self.problem = chunk.problem
            if self.problem is None:
                assert chunk.packed is not None
                self._put(chunk.info, len(chunk.plain), len(chunk.packed), [chunk.packed], chunk.indexes)
            with self._moved:
                self._order.popleft()
                self._bytes -= chunk.ahead
                self._moved.notify_all()

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
