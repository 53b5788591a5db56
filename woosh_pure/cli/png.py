"""PNG images from arrays with nothing but zlib (www.w3.org/TR/png, sections 5 and 11)."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from woosh_pure.values import Image

__all__ = ["encode_png", "image_png"]

_KINDS = {1: 0, 3: 2, 4: 6}
"""Channels -> colour type: grey, RGB, RGBA."""


def encode_png(pixels: NDArray[np.generic]) -> bytes:
    """A PNG of (height, width) or (height, width, 3 or 4) uint8 or uint16.

    Raises:
        ValueError: Another shape or type.
    """
    import numpy as np

    channels = 1 if pixels.ndim == 2 else pixels.shape[-1] if pixels.ndim == 3 else 0
    if channels not in _KINDS or pixels.dtype not in (np.uint8, np.uint16) or 0 in pixels.shape:
        raise ValueError(f"no PNG of shape {pixels.shape}, {pixels.dtype}; expected uint8 or uint16 pixels")
    height, width = pixels.shape[:2]
    size = pixels.dtype.itemsize
    rows = np.ascontiguousarray(pixels, dtype=pixels.dtype.newbyteorder(">")).reshape(height, -1)
    scanlines = np.zeros((height, 1 + rows.shape[1] * size), np.uint8)  # the first byte: filter type none
    scanlines[:, 1:] = rows.view(np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * size, _KINDS[channels], 0, 0, 0)
    body = zlib.compress(scanlines.tobytes(), 6)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def image_png(image: Image) -> bytes:
    """A PNG of a camera image; depth becomes 16-bit grey in mm, 0 where nothing was measured.

    Raises:
        ValueError: The encoding cannot be shown.
    """
    import numpy as np

    pixels = image.pixels
    if image.encoding in ("16UC1", "mono16", "32FC1"):
        millimetres = np.nan_to_num(image.depth_metres() * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
        return encode_png(np.clip(np.rint(millimetres), 0, 65535).astype(np.uint16))
    if image.encoding in ("bgr8", "8UC3"):
        pixels = pixels[..., ::-1]
    elif image.encoding == "bgra8":
        pixels = pixels[..., [2, 1, 0, 3]]
    return encode_png(pixels)
