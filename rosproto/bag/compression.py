"""Chunk compression: none, bz2, and the profile of LZ4 frames that ROS reads.

rosbag's own LZ4 reader accepts only frames with independent blocks, no block checksum, no content size, no
dictionary, and with a content checksum (roslz4 lz4s.c, processHeader). The defaults of every LZ4 library
give something else, and rosbag then says "malformed data to decompress".
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Literal

from rosproto.errors import BagError

COMPRESSIONS: tuple[Literal["none", "bz2", "lz4"], ...] = ("none", "bz2", "lz4")


def compressor(name: str) -> Callable[[bytes], bytes]:
    """The function that compresses a chunk.

    Raises:
        BagError: The lz4 package is missing.
        ValueError: No such compression.
    """
    if name == "none":
        return bytes
    if name == "bz2":
        import bz2

        return bz2.compress
    if name == "lz4":
        _lz4()  # report a missing package now, not at the first chunk
        return _lz4_compress
    raise ValueError(f"compression {name!r}: a bag supports {', '.join(COMPRESSIONS)}")


def _lz4_compress(data: bytes) -> bytes:
    frame = _lz4()
    packed: bytes = frame.compress(
        data,
        compression_level=0,
        block_size=frame.BLOCKSIZE_MAX1MB,
        block_linked=False,
        content_checksum=True,
        block_checksum=False,
        store_size=False,
    )
    return packed


def decompress(name: str, data: bytes | memoryview, size: int) -> bytes:
    """Decompress a whole chunk.

    Args:
        name: Compression from the chunk header.
        data: The chunk's data.
        size: Uncompressed size from the chunk header; more is never produced.

    Raises:
        BagError: The data is damaged or has another size.
    """
    plain, complete = decompress_prefix(name, data, size)
    if not complete:
        raise BagError(
            f"a {name} chunk of {len(data)} bytes gives {len(plain)} bytes, its header says {size}"
        )
    return plain


def decompress_prefix(name: str, data: bytes | memoryview, size: int) -> tuple[bytes, bool]:
    """Decompress the readable beginning of a damaged or truncated chunk.

    Returns:
        The uncompressed bytes, at most `size`, and whether they are complete, with valid checksums.

    Raises:
        BagError: Nothing can be recovered: unknown compression, or damage at the very start.
    """
    if name == "none":
        return bytes(data[:size]), len(data) == size
    if name == "bz2":
        return _bz2_prefix(data, size)
    if name == "lz4":
        return _lz4_prefix(data, size)
    raise BagError(f"a chunk has compression {name!r}; known are {', '.join(COMPRESSIONS)}")


def _bz2_prefix(data: bytes | memoryview, size: int) -> tuple[bytes, bool]:
    import bz2

    whole = bz2.BZ2Decompressor()
    try:
        plain = whole.decompress(data, size + 1)
        # Without room for one more byte the end of stream (and its checksum) would not have been reached.
        if len(plain) <= size and whole.eof:
            return plain, len(plain) == size
        return plain[:size], False
    except (OSError, EOFError):
        pass
    return _up_to_damage(bz2.BZ2Decompressor().decompress, data, size), False


def _lz4_prefix(data: bytes | memoryview, size: int) -> tuple[bytes, bool]:
    frame = _lz4()
    try:
        # The buffer is allocated in one piece, so a wild size in the header is capped by the most that LZ4
        # can expand to (255 to 1). With room for one block more than needed, LZ4 decompresses straight into
        # it; without that room it goes through a buffer of its own first.
        room = min(size, 256 * len(data)) + _lz4_block_bytes(data)
        # Not LZ4FrameDecompressor, which copies any input other than bytes.
        context = frame.create_decompression_context()
        plain, _, whole = frame.decompress_chunk(context, data, max_length=room)
        if whole and len(plain) == size:
            return plain, True
        return plain[:size], False
    except (RuntimeError, EOFError, ValueError):
        pass
    return _up_to_damage(frame.LZ4FrameDecompressor().decompress, data, size), False


def _lz4_block_bytes(data: bytes | memoryview) -> int:
    """The largest size of a decompressed block, as the frame's fifth byte gives it: 64 KiB to 4 MiB."""
    code = data[5] >> 4 & 7 if len(data) > 5 else 0
    return 1 << (2 * code + 8) if 4 <= code <= 7 else 1 << 16


def _up_to_damage(
    decompress: Callable[[bytes | memoryview, int], bytes], data: bytes | memoryview, size: int
) -> bytes:
    """Decompress in small steps up to the damage (bz2's blocks are 900 kB)."""
    got = bytearray()
    try:
        for at in range(0, len(data), 4096):
            got += decompress(data[at : at + 4096], max(size - len(got), 0))
    except (OSError, EOFError, RuntimeError, ValueError):
        pass
    return bytes(got)


@cache
def keep_freed_memory() -> None:
    """Have the C library keep the memory of a freed chunk for the next one.

    glibc returns large blocks to the system whenever they are freed, and faults new ones in page by page for
    the next chunk. It stops doing so for sizes up to the largest block it has seen freed, and keeps up to
    twice that much (mallopt(3), M_MMAP_THRESHOLD). The block freed here is the largest that it takes as an
    example, and costs nothing, since it is never touched. Other C libraries are not affected. Without it,
    reading LZ4 takes 1.7 to 2 times the processor time, and writing it twice the time.
    """
    bytes((32 << 20) - (8 << 10))


def _lz4() -> ModuleType:
    try:
        import lz4.frame  # type: ignore[import-untyped]
    except ModuleNotFoundError as problem:
        raise BagError("LZ4 chunks need the lz4 package: pip install lz4") from problem
    frame: ModuleType = lz4.frame
    return frame
