"""The messages of one MCAP chunk."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import ChunkData
from rosproto.bag.compression import decompress
from rosproto.bag.mcap.library import library, misfits
from rosproto.bag.mcap.source import SafeStream
from rosproto.bag.records import NS, ChunkInfo
from rosproto.bag.rows import Place, Rows
from rosproto.errors import BagError

__all__ = ["LOOSE", "McapChunk", "messages_of", "read_mcap_chunk"]

LOOSE = 1024  # how many messages outside of chunks are read together


class McapChunk(ChunkData):
    """A chunk's messages, one after the other.

    It is never said to be packed: the library takes chunks apart by plain Python, which helper threads do not
    make faster.

    Args:
        info: The chunk they came from.
        blob: Their data.
        messages: Channel, time (ns) and bytes of each.
    """

    def __init__(self, info: ChunkInfo, blob: bytes, messages: list[tuple[int, int, int]]) -> None:
        super().__init__(info, blob, 0, len(blob))
        self._messages = messages

    def rows(self, wanted: Collection[int] | None = None) -> Rows:
        """As `ChunkData.rows`."""
        import numpy as np

        table = np.array(self._messages, np.uint64).reshape(-1, 3)
        time, sizes = table[:, 1], table[:, 2].astype(np.int64)
        secs = time // NS
        if (secs > 0xFFFFFFFF).any():
            raise BagError("a message's time is later than ROS can tell (the year 2106)")
        stop = np.cumsum(sizes)
        rows = Rows(
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
    ) -> Sequence[Place]:
        """As `ChunkData.places`."""
        return self.rows(wanted).between(low, high).in_time_order().places()


def read_mcap_chunk(source: BagFile, info: ChunkInfo, loose: bool) -> McapChunk:
    """The chunk, or the messages outside of chunks, that begin there.

    Raises:
        BagError: It is damaged.
    """
    limit = min(source.size, source.limits.chunk_bytes + (1 << 20))
    reader = library("stream_reader").StreamReader(
        SafeStream(source, info.pos), skip_magic=True, emit_chunks=True, record_size_limit=limit
    )
    messages: list[Any] = []
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
        raise source.error(f"no whole record: {problem or type(problem).__name__}", info.pos) from None
    messages = [message for message in messages if message.channel_id in info.counts]
    blob = b"".join([message.data for message in messages])
    facts = [(message.channel_id, message.log_time, len(message.data)) for message in messages]
    return McapChunk(info, blob, facts)


def messages_of(
    source: BagFile, chunk: Any, at: int, others: Callable[[Any], None] | None = None
) -> list[Any]:
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
        raise source.error(f"it cannot be taken apart: {problem or type(problem).__name__}", at) from None
    if not source.records.take(at, len(records)):
        raise source.error("more records than a file of its size may have", at)
    messages: list[Any] = []
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
        try:
            import zstandard
        except ImportError as problem:  # the package mcap requires it
            raise BagError("zstd chunks need the package zstandard: pip install zstandard") from problem
        try:
            with zstandard.ZstdDecompressor().stream_reader(data) as stream:
                plain: bytes = stream.read(size + 1)
        except zstandard.ZstdError as problem:
            raise BagError(f"zstd data is damaged: {problem}") from None
        return plain
    raise BagError(f"a chunk has compression {compression!r}; known are lz4 and zstd")
