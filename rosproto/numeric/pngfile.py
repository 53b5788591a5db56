"""Encode arrays as PNG and decode PNG, with nothing but zlib (www.w3.org/TR/png). Pure.

Both packages use it for all PNGs. Interlaced pictures are not supported. Every size is checked before memory
is allocated.
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np

from rosproto.sentence import say

if TYPE_CHECKING:
    from numpy.typing import NDArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_KINDS = {1: 0, 3: 2, 4: 6}
"""Channels -> colour type when writing: grey, RGB, RGBA."""


def encode_png(pixels: NDArray[np.generic]) -> bytes:
    """A PNG of (height, width) or (height, width, 3 or 4) uint8 or uint16.

    Raises:
        ValueError: Wrong shape or dtype.
    """
    channels = 1 if pixels.ndim == 2 else pixels.shape[-1] if pixels.ndim == 3 else 0
    if channels not in _KINDS or pixels.dtype not in (np.uint8, np.uint16) or 0 in pixels.shape:
        raise ValueError(
            f"cannot make a PNG of shape {pixels.shape}, {pixels.dtype}; expected uint8 or uint16 pixels"
        )
    height, width = pixels.shape[:2]
    size = pixels.dtype.itemsize
    rows = np.ascontiguousarray(pixels, dtype=pixels.dtype.newbyteorder(">")).reshape(height, -1)
    scanlines = np.zeros((height, 1 + rows.shape[1] * size), np.uint8)  # the first byte: filter type none
    scanlines[:, 1:] = rows.view(np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * size, _KINDS[channels], 0, 0, 0)
    body = zlib.compress(scanlines.data, 6)
    return SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def is_png(data: bytes) -> bool:
    """Whether bytes begin like a PNG."""
    return data.startswith(SIGNATURE)


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def decode_png(data: bytes, limit_pixels: int, limit_rows: int = 1 << 31) -> NDArray[np.uint8]:
    """Pixels of a PNG.

    Args:
        data: The file.
        limit_pixels: Largest width times height.
        limit_rows: Largest height; a row takes ten microseconds, however short.

    Returns:
        (height, width, channels) uint8: grey, grey and alpha, RGB, or RGBA; 16 bits are reduced to 8,
        palettes are resolved.

    Raises:
        ValueError: No PNG, too large, truncated, or interlaced.
    """
    chunks = _chunks(data)
    if len(chunks.get(b"IHDR", b"")) != 13:
        raise ValueError("not a PNG picture: it has no header")
    width, height, depth, kind, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    if interlaced:
        raise ValueError("an interlaced PNG cannot be read here; save it without interlacing")
    if kind not in _CHANNELS or depth not in (1, 2, 4, 8, 16):
        raise ValueError(say("not a PNG picture: colour type {kind}, {depth} bits", kind=kind, depth=depth))
    if not 0 < width * height <= limit_pixels:
        raise ValueError(f"{width} x {height} pixels; expected 1 to {limit_pixels}")
    if height > limit_rows:
        raise ValueError(f"{height} rows of pixels; expected at most {limit_rows}")
    rows = _unfiltered(chunks.get(b"IDAT", b""), width, height, depth * _CHANNELS[kind])
    pixels = _samples(rows, width, depth, _CHANNELS[kind])
    return _from_palette(pixels, chunks.get(b"PLTE", b"")) if kind == 3 else _eight_bits(pixels, depth)


def _chunks(data: bytes) -> dict[bytes, bytes]:
    if not is_png(data):
        raise ValueError("not a PNG picture")
    found: dict[bytes, bytes] = {}
    picture: list[bytes] = []  # joined once: a hostile picture may have a chunk for every byte
    at = len(SIGNATURE)
    while at + 8 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        if len(body) != length:
            raise ValueError("the PNG picture is cut short")
        if kind == b"IDAT":
            picture.append(body)
        else:
            found[kind] = body
        at += 12 + length
    found[b"IDAT"] = b"".join(picture)
    return found


def _unfiltered(packed: bytes, width: int, height: int, bits: int) -> NDArray[np.uint8]:
    """(height, bytes of a row) without the filter bytes; each row is filtered by the one above it."""
    size = (width * bits + 7) // 8
    step = max(1, bits // 8)
    unpacker = zlib.decompressobj()
    try:
        raw = unpacker.decompress(packed, height * (size + 1))
    except zlib.error as error:
        raise ValueError(say("the PNG picture is damaged: {error}", error=error)) from error
    if len(raw) != height * (size + 1):
        raise ValueError("the PNG picture is cut short")
    lines = np.frombuffer(raw, np.uint8).reshape(height, size + 1)
    rows = np.zeros((height + 1, size), np.uint8)
    for number, line in enumerate(lines):
        rows[number + 1] = _row(int(line[0]), line[1:], rows[number], step)
    return rows[1:]


def _row(kind: int, line: NDArray[np.uint8], above: NDArray[np.uint8], step: int) -> NDArray[np.uint8]:
    if kind == 0:
        return line
    if kind == 2:
        return line + above
    if kind == 1:  # differences to the left, per byte of a pixel: a running sum modulo 256
        out = np.zeros_like(line)
        for first in range(min(step, line.size)):
            out[first::step] = np.cumsum(line[first::step], dtype=np.uint8)
        return out
    if kind not in (3, 4):
        raise ValueError(f"the PNG picture is damaged: filter {kind}")
    return np.frombuffer(_by_neighbours(kind, line.tobytes(), above.tobytes(), step), np.uint8)


def _by_neighbours(kind: int, line: bytes, above: bytes, step: int) -> bytes:
    out = bytearray(line)
    for i, value in enumerate(line):
        left = out[i - step] if i >= step else 0
        up = above[i]
        if kind == 3:
            out[i] = (value + (left + up) // 2) & 255
        else:
            corner = above[i - step] if i >= step else 0
            out[i] = (value + _paeth(left, up, corner)) & 255
    return bytes(out)


def _paeth(left: int, up: int, corner: int) -> int:
    guess = left + up - corner
    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
    if a <= b and a <= c:
        return left
    return up if b <= c else corner


def _samples(rows: NDArray[np.uint8], width: int, depth: int, channels: int) -> NDArray[np.uint8]:
    """(height, width, channels): small samples unpacked, large ones reduced to the high byte."""
    height = rows.shape[0]
    if depth == 16:
        rows = rows[:, ::2]
    elif depth < 8:
        bits = np.unpackbits(rows, axis=1).reshape(height, -1, depth)
        rows = bits @ (1 << np.arange(depth - 1, -1, -1, dtype=np.uint8))
    return np.ascontiguousarray(rows[:, : width * channels]).reshape(height, width, channels)


def _eight_bits(pixels: NDArray[np.uint8], depth: int) -> NDArray[np.uint8]:
    return pixels * np.uint8(255 // ((1 << depth) - 1)) if depth < 8 else pixels


def _from_palette(pixels: NDArray[np.uint8], palette: bytes) -> NDArray[np.uint8]:
    colours = np.frombuffer(palette[: len(palette) // 3 * 3], np.uint8).reshape(-1, 3)
    if pixels.size and int(pixels.max()) >= len(colours):
        raise ValueError("the PNG picture is damaged: a colour is not in its palette")
    return np.asarray(colours[pixels[:, :, 0]], dtype=np.uint8)
