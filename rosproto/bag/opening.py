"""Open bags and MCAP files: the first bytes decide the format to read, the file name the format to write."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, BinaryIO

from rosproto.bag.bag_file import BagFile, BagLimits, Scanning
from rosproto.bag.reader import BagReader
from rosproto.bag.writer import BagWriter
from rosproto.errors import BagError

if TYPE_CHECKING:
    from rosproto.bag.mcap import McapWriter


_MCAP = b"\x89MCAP"


def open_bag(
    file: str | os.PathLike[str] | BinaryIO,
    *,
    skip_damaged: bool = False,
    limits: BagLimits | None = None,
    scanning: Scanning | None = None,
) -> BagReader:
    """Open a bag or an MCAP file for reading; the name does not matter.

    Args:
        file: Path, a URL that fsspec supports (extra `remote`), or a seekable binary file. Of a remote file,
            only the required parts are fetched.
        skip_damaged: See `BagReader`.
        limits: See `BagReader`.
        scanning: See `BagReader`.

    Raises:
        BagError: The file cannot be opened, or is neither a bag nor an MCAP file.
    """
    source = BagFile(file, limits, scanning)
    try:
        mcap = source.read_at(0, len(_MCAP)) == _MCAP
    except BaseException:
        source.close()
        raise
    if mcap:
        from rosproto.bag.mcap import McapReader

        return McapReader(source, skip_damaged=skip_damaged)
    return BagReader(source, skip_damaged=skip_damaged)


def is_mcap_name(path: str | os.PathLike[str]) -> bool:
    """Whether the name is that of an MCAP file."""
    return os.fspath(path).lower().endswith(".mcap")


def create_bag(
    path: str | os.PathLike[str],
    compression: Any = "none",
    chunk_bytes: int = 768 * 1024,
    *,
    mcap: bool | None = None,
) -> BagWriter | McapWriter:
    """Create a recording and return its writer.

    Args:
        path: An existing file is replaced.
        compression: "none" or "lz4"; also "bz2" for a bag, "zstd" for MCAP.
        chunk_bytes: See `BagWriter`.
        mcap: True for MCAP, False for a bag; None: MCAP if the name ends in `.mcap`.

    Raises:
        BagError: The file cannot be opened, or the format does not support the compression.
    """
    if is_mcap_name(path) if mcap is None else mcap:
        from rosproto.bag.mcap import McapWriter

        if compression == "bz2":
            raise BagError("MCAP cannot use bz2; use lz4 or zstd", path=os.fspath(path))
        return McapWriter(path, compression, chunk_bytes)
    if compression == "zstd":
        raise BagError("a bag cannot use zstd; use lz4 or bz2", path=os.fspath(path))
    return BagWriter(path, compression, chunk_bytes)
