"""Packs and unpacks rosbridge's `png` compression: a JSON text as the pixels of an RGB picture, in base64.

The bytes of the text fill an approximately square picture row by row, padded with newlines, which JSON
ignores (rosbridge_library.internal.pngcompression).
"""

from __future__ import annotations

import binascii
from math import isqrt

from rosproto.gateway.chunks import ChunkedMessage

MAX_PICTURE_BYTES = 256 << 10
"""Longest text from a client: undoing the filters takes up to a microsecond for three bytes."""
MAX_ROWS = 4096
"""Most rows of a client's picture; each takes ten microseconds."""


class PngError(Exception):
    """A client's picture is not valid; the text is a sentence for the client."""


def pack(text: str | ChunkedMessage) -> str:
    """The base64 of a picture whose pixels are a text; the inverse of `unpack`."""
    import numpy as np

    from rosproto.numeric.pngfile import encode_png

    parts = text.chunks if isinstance(text, ChunkedMessage) else (text or "\n",)
    encoded = [part.encode("utf-8", "replace") for part in parts if isinstance(part, str)]
    pixels = -(-sum(map(len, encoded)) // 3)
    width = max(1, isqrt(pixels))
    height = -(-pixels // width)
    picture = np.full(height * width * 3, ord("\n"), np.uint8)
    at = 0
    for data in encoded:
        picture[at : at + len(data)] = np.frombuffer(data, np.uint8)
        at += len(data)
    return binascii.b2a_base64(encode_png(picture.reshape(height, width, 3)), newline=False).decode("ascii")


def publish_png(text: str | ChunkedMessage) -> str:
    """The operation `png` that contains another message, given as JSON text."""
    return f'{{"op": "png", "data": "{pack(text)}"}}'


def unpack(data: str, max_bytes: int = MAX_PICTURE_BYTES) -> str:
    """The text in a picture.

    Args:
        data: Base64 of a PNG.
        max_bytes: Longest text and longest picture; checked before memory is taken.

    Raises:
        PngError: The picture or its text is not valid, or too long.
    """
    from rosproto.numeric.pngfile import decode_png

    if len(data) > max_bytes * 4 // 3 + 4:
        raise PngError(f"the picture has more than the limit of {max_bytes} bytes")
    try:
        pixels = decode_png(binascii.a2b_base64(data), max_bytes // 3, MAX_ROWS)
    except ValueError as error:  # binascii.Error is one
        raise PngError(f"not a PNG picture in base64: {error}") from None
    if pixels.shape[2] != 3:
        raise PngError(f"the picture has {pixels.shape[2]} channels; expected red, green and blue")
    try:
        return pixels.tobytes().decode("utf-8")
    except UnicodeDecodeError as error:
        raise PngError(f"the picture's bytes are not UTF-8: {error}") from None
