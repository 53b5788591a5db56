"""Ways in which a byte stream may arrive."""

from __future__ import annotations

from collections.abc import Iterator


def every_split(data: bytes, *, most: int = 200) -> Iterator[list[bytes]]:
    """The data whole, byte by byte, and cut once at every place (at `most` places, spread evenly)."""
    yield [data]
    yield [data[i : i + 1] for i in range(len(data))]
    step = max(1, len(data) // most)
    for cut in range(1, len(data), step):
        yield [data[:cut], data[cut:]]


def slices_of_one_buffer(pieces: list[bytes]) -> Iterator[memoryview]:
    """The pieces as views of one buffer that is overwritten after each use: nothing may be kept of it."""
    buffer = bytearray(max((len(piece) for piece in pieces), default=0))
    for piece in pieces:
        buffer[: len(piece)] = piece
        yield memoryview(buffer)[: len(piece)]
        buffer[:] = b"\xee" * len(buffer)
