"""Splits of a byte stream into received pieces."""

from __future__ import annotations

from collections.abc import Iterator


def every_split(data: bytes, *, most: int = 200) -> Iterator[list[bytes]]:
    """Yield the data whole, byte by byte, and cut once at each position (at most `most`, evenly spread)."""
    yield [data]
    yield [data[i : i + 1] for i in range(len(data))]
    step = max(1, len(data) // most)
    for cut in range(1, len(data), step):
        yield [data[:cut], data[cut:]]


def slices_of_one_buffer(pieces: list[bytes]) -> Iterator[memoryview]:
    """Yield the pieces as views of one buffer that is overwritten after each use: users must copy."""
    buffer = bytearray(max((len(piece) for piece in pieces), default=0))
    for piece in pieces:
        buffer[: len(piece)] = piece
        yield memoryview(buffer)[: len(piece)]
        buffer[:] = b"\xee" * len(buffer)
