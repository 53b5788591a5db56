"""Read the PNG files that our commands write, by the specification alone (www.w3.org/TR/png)."""

from __future__ import annotations

import zlib

import numpy as np

__all__ = ["read_png"]


def read_png(data: bytes) -> np.ndarray:
    """Pixels of a PNG without filters, checked: signature, sums, sizes."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == int.from_bytes(data[at + 8 + length : at + 12 + length], "big")
        chunks[kind] = body
        at += 12 + length
    width, height = int.from_bytes(chunks[b"IHDR"][:4], "big"), int.from_bytes(chunks[b"IHDR"][4:8], "big")
    depth, kind = chunks[b"IHDR"][8], chunks[b"IHDR"][9]
    channels = {0: 1, 2: 3, 6: 4}[kind]
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, -1)
    assert not rows[:, 0].any()
    pixels = np.ascontiguousarray(rows[:, 1:]).view(">u2" if depth == 16 else np.uint8)
    return pixels.reshape(height, width, channels)
