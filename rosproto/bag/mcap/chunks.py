"""Read the messages of one MCAP chunk with the optional library mcap."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Collection, Sequence
from types import ModuleType
from typing import TYPE_CHECKING

from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import ChunkData
from rosproto.bag.compression import decompress
from rosproto.bag.message_offsets import MessageLocation, MessageTable
from rosproto.bag.records import NS, ChunkInfo
from rosproto.errors import BagError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    from mcap.records import Chunk, McapRecord
    from mcap.records import Message as McapMessage

# -- the optional library -----------------------------------------------------------------------------------


def library(module: str) -> ModuleType:
    """One of the library's modules: "writer", "reader", "stream_reader".

    Raises:
        BagError: It is not installed; names the extra.
    """
    missing = BagError('MCAP needs the package mcap: pip install ".[mcap]"')
    return optional_module(f"mcap.{module}", missing)


def misfits() -> tuple[type[Exception], ...]:
    """The library's errors for damaged MCAP files."""
    error: type[Exception] = library("exceptions").McapError
    return error, ValueError, KeyError, OverflowError, EOFError, struct.error, RuntimeError


# -- the stream it reads from -------------------------------------------------------------------------------


class BoundedStream:
    """A stream over a `BagFile`.

    Args:
        source: The file.
        begin: Position of its first byte.
    """

    def __init__(self, source: BagFile, begin: int = 0) -> None:
        self._source = source
        self._at = begin

    def read(self, size: int = -1) -> bytes:
        left = max(0, self._source.size - self._at)
        data = self._source.read_at(self._at, left if size < 0 else min(size, left))
        self._at += len(data)
        return data

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._source.size}[whence]
        if base + offset < 0:
            raise ValueError(f"a position {base + offset} before the beginning of the file")
        self._at = base + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def seekable(self) -> bool:
        return True


# -- chunks -------------------------------------------------------------------------------------------------


LOOSE = 1024  # number of messages outside of chunks that are read together


class McapChunk(ChunkData):
    """A chunk's messages, one after the other.

    It is never marked as packed: the library parses chunks in Python, which helper threads do not speed up.

    Args:
        info: The chunk they came from.
        blob: Their data.
        messages: Channel, time (ns) and bytes of each.
    """

    def __init__(self, info: ChunkInfo, blob: bytes, messages: list[tuple[int, int, int]]) -> None:
        super().__init__(info, blob, 0, len(blob))
        self._messages = messages

    def rows(self, wanted: Collection[int] | None = None) -> MessageTable:
        """As `ChunkData.rows`."""
        import numpy as np

        table = np.array(self._messages, np.uint64).reshape(-1, 3)
        time, sizes = table[:, 1], table[:, 2].astype(np.int64)
        secs = time // NS
        if (secs > 0xFFFFFFFF).any():
            raise BagError("a message's time is later than ROS can represent (the year 2106)")
        stop = np.cumsum(sizes)
        rows = MessageTable(
            table[:, 0].astype(np.uint32),
            secs.astype(np.uint32),
            (time - secs * NS).astype(np.uint32),
            stop - sizes,
            stop,
        )
        if wanted is None:
            return rows
        return rows.take(np.isin(rows.conn, np.fromiter(wanted, np.uint32)))

    def places(
        self, wanted: Collection[int], low: int | None = None, high: int | None = None
    ) -> Sequence[MessageLocation]:
        """As `ChunkData.places`."""
        return self.rows(wanted).between(low, high).in_time_order().places()


def read_mcap_chunk(source: BagFile, info: ChunkInfo, loose: bool) -> McapChunk:
    """Read the chunk, or the messages outside of chunks, at `info.pos`.

    Raises:
        BagError: It is damaged.
    """
    limit = min(source.size, source.limits.chunk_bytes + (1 << 20))
    reader = library("stream_reader").StreamReader(
        BoundedStream(source, info.pos), skip_magic=True, emit_chunks=True, record_size_limit=limit
    )
    messages: list[McapMessage] = []
    try:
        for record in reader.records:
            if loose and type(record).__name__ == "Message":
                messages.append(record)
                if len(messages) == sum(info.counts.values()):
                    break
            elif not loose:
                if type(record).__name__ != "Chunk":
                    raise source.error("expected a chunk", info.pos)
                messages = messages_of(source, record, info.pos)
                break
    except misfits() as problem:
        raise source.error(f"not a complete record: {problem or type(problem).__name__}", info.pos) from None
    messages = [message for message in messages if message.channel_id in info.counts]
    blob = b"".join([message.data for message in messages])
    facts = [(message.channel_id, message.log_time, len(message.data)) for message in messages]
    return McapChunk(info, blob, facts)


def messages_of(
    source: BagFile, chunk: Chunk, at: int, others: Callable[[McapRecord], None] | None = None
) -> list[McapMessage]:
    """A chunk record's messages; its schemas and channels go to `others`.

    Raises:
        BagError: It is damaged, or would take more memory than `BagLimits` allow.
    """
    size = chunk.uncompressed_size
    if max(size, len(chunk.data)) > source.limits.chunk_bytes:
        raise source.error(f"a chunk of {size} bytes, at most {source.limits.chunk_bytes} are read", at)
    reader = library("stream_reader")
    try:
        if chunk.compression:
            source.allow_unpacking(at, size)
            chunk.data = _unpacked(chunk.compression, chunk.data, size)
            chunk.compression = ""
        if len(chunk.data) != size:
            raise source.error(f"a chunk of {len(chunk.data)} bytes, its record says {size}", at)
        records = reader.breakup_chunk(chunk, validate_crc=True)
    except misfits() as problem:
        raise source.error(f"it cannot be parsed: {problem or type(problem).__name__}", at) from None
    if not source.records.take(at, len(records)):
        raise source.error("more records than a file of its size may have", at)
    messages: list[McapMessage] = []
    for record in records:
        if type(record).__name__ == "Message":
            messages.append(record)
        elif others is not None:
            others(record)
    return messages


def _unpacked(compression: str, data: bytes, size: int) -> bytes:
    """The decompressed bytes, never more than the record declares."""
    if compression == "lz4":
        return decompress("lz4", data, size)
    if compression == "zstd":
        # The package mcap requires it.
        missing = BagError("zstd chunks need the package zstandard: pip install zstandard")
        zstandard = optional_module("zstandard", missing)
        try:
            with zstandard.ZstdDecompressor().stream_reader(data) as stream:
                plain: bytes = stream.read(size + 1)
        except zstandard.ZstdError as problem:
            raise BagError(f"zstd data is damaged: {problem}") from None
        return plain
    raise BagError(f"a chunk has compression {compression!r}; known are lz4 and zstd")
