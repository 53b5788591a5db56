"""Read MCAP files with the interface of `BagReader`."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, BinaryIO

from rosproto.bag.bag_file import BagFile, Scanning
from rosproto.bag.chunk import ChunkData
from rosproto.bag.limits import BagLimits
from rosproto.bag.mcap.chunks import read_mcap_chunk
from rosproto.bag.mcap.contents import MCAP_MAGIC, read_contents
from rosproto.bag.reader import BagReader, Compression
from rosproto.bag.records import ChunkInfo

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["MCAP_MAGIC", "McapReader"]


class McapReader(BagReader):
    """An MCAP file with messages of ROS 1 (profile `ros1`), with the interface of `BagReader`.

    Channels are connections; a channel's metadata are its connection header. A file whose recorder died has
    no summary: it is scanned, `damage` says so, and every complete message can be read.

    Args:
        file: Path, URL (extra `remote`), or a seekable binary file.
        skip_damaged: As for `BagReader`.
        limits: As for `BagReader`.
        scanning: As for `BagReader`.

    Raises:
        BagError: It cannot be opened, is no MCAP file, or the package mcap is missing (extra `mcap`).
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | BinaryIO | BagFile,
        *,
        skip_damaged: bool = False,
        limits: BagLimits | None = None,
        scanning: Scanning | None = None,
    ) -> None:
        self._source = file if isinstance(file, BagFile) else BagFile(file, limits, scanning)
        try:
            if self._source.read_at(0, len(MCAP_MAGIC)) != MCAP_MAGIC:
                raise self._source.error("this is no MCAP file")
            found = read_contents(self._source)
            self._source.searched()
        except BaseException:
            self._source.close()
            raise
        self._loose = found.loose
        self._lost = found.lost
        self._packed = found.packed
        self._spans = {}
        self._take_contents(found.connections, found.chunks, found.damage)
        self._skip = skip_damaged
        self.version = "MCAP 0"
        self.indexed = found.finished

    def _index_times(self, info: ChunkInfo, wanted: Collection[int]) -> NDArray[np.int64] | None:
        return None  # from the messages themselves

    def compression(self, *, step: Callable[[], None] | None = None) -> dict[str, Compression]:
        """How the chunks are compressed, by "none", "lz4" and "zstd"; opening the file has told that."""
        kinds: dict[str, Compression] = {}
        for info in self.chunks:
            # Messages outside of chunks have no such sizes.
            name, stored, plain = self._packed.get(info.pos, ("", 0, 0))
            was = kinds.get(name or "none", Compression(0, 0, 0))
            kinds[name or "none"] = Compression(
                was.chunks + 1, was.stored_bytes + stored, was.plain_bytes + plain
            )
            if step is not None:
                step()
        return kinds

    def _read_chunk(self, info: ChunkInfo, most: int | None = None) -> ChunkData:
        return read_mcap_chunk(self._source, info, info.pos in self._loose)
