"""Read MCAP files with the interface of `BagReader`."""

from __future__ import annotations

import os
from collections.abc import Collection
from typing import TYPE_CHECKING, BinaryIO, cast

from rosproto.bag.bag_file import BagFile
from rosproto.bag.chunk import ChunkData
from rosproto.bag.large_messages import Found
from rosproto.bag.limits import BagLimits
from rosproto.bag.mcap.chunks import read_mcap_chunk
from rosproto.bag.mcap.contents import read_contents
from rosproto.bag.mcap.library import library, misfits
from rosproto.bag.mcap.source import SafeStream
from rosproto.bag.read_ahead import Following, ReadAhead
from rosproto.bag.reader import BagReader, Compression
from rosproto.bag.records import ChunkInfo
from rosproto.errors import BagError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["MCAP_MAGIC", "McapReader"]

MCAP_MAGIC = b"\x89MCAP0\r\n"


class McapReader(BagReader):
    """An MCAP file with messages of ROS 1 (profile `ros1`), with the interface of `BagReader`.

    Channels are connections; a channel's metadata are its connection header. A file whose recorder died has
    no summary: it is scanned, `damage` says so, and every complete message can be read.

    Args:
        file: Path, or a seekable binary file.
        skip_damaged: As for `BagReader`.
        limits: As for `BagReader`.

    Raises:
        BagError: It cannot be opened, is no MCAP file, or the package mcap is missing (extra `mcap`).
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO,
        *,
        skip_damaged: bool = False,
        limits: BagLimits | None = None,
    ) -> None:
        self._source = BagFile(file, limits)
        try:
            if self._source.read_at(0, len(MCAP_MAGIC)) != MCAP_MAGIC:
                raise self._source.error("this is no MCAP file")
            found = read_contents(self._source)
        except BaseException:
            self._source.close()
            raise
        self._loose = found.loose
        self._lost = found.lost
        self._spans = {}
        self._take_contents(found.connections, found.chunks, found.damage)
        self._skip = skip_damaged
        self.version = "MCAP 0"
        self.indexed = found.finished

    def times(self, topic: str) -> NDArray[np.int64]:
        """Receive times of a topic's messages, ns, sorted, (N,) int64; reads the messages."""
        import numpy as np

        stamps = [s.secs * 1_000_000_000 + s.nsecs for _, _, s in self.read_messages(topic, raw="view")]
        return np.array(stamps, np.int64)

    def compression(self) -> dict[str, Compression]:
        """How the chunks are compressed, by "none", "lz4" and "zstd"; reads them."""
        kinds: dict[str, Compression] = {}
        for info in self.chunks:
            name, stored, plain = self._sizes(info)
            was = kinds.get(name, Compression(0, 0, 0))
            kinds[name] = Compression(was.chunks + 1, was.stored_bytes + stored, was.plain_bytes + plain)
        return kinds

    def _sizes(self, info: ChunkInfo) -> tuple[str, int, int]:
        if info.pos in self._loose:
            return "none", 0, 0
        reader = library("stream_reader").StreamReader(
            SafeStream(self._source, info.pos), skip_magic=True, emit_chunks=True, record_size_limit=self.size
        )
        unusable: tuple[type[Exception], ...] = (*misfits(), StopIteration, AttributeError)
        try:
            chunk = next(reader.records)
            return chunk.compression or "none", len(chunk.data), chunk.uncompressed_size
        except unusable:
            return "none", 0, 0  # damage is reported where messages are read

    def _alone(self, order: list[ChunkInfo]) -> list[bool]:
        return [False] * len(order)  # here there is no quicker way for few messages

    def _few_messages(self, info: ChunkInfo, wanted: Collection[int]) -> list[Found] | None:
        return None

    def _load(
        self, info: ChunkInfo, ahead: ReadAhead | None = None, following: Following | None = None
    ) -> ChunkData | None:
        self._source.check_open()
        try:
            # Both kinds of chunk have everything that is used of a chunk here.
            return cast("ChunkData", read_mcap_chunk(self._source, info, info.pos in self._loose))
        except BagError as problem:
            self._skipped(info, problem)
            return None
