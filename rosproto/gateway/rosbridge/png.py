"""rosbridge's `png` compression: a JSON text as the pixels of an RGB picture, in base64.

The bytes of the text fill a picture that is about square, row by row; newlines fill what is left over
(rosbridge_library.internal.pngcompression). JSON ignores them.
"""

from __future__ import annotations

import binascii
from math import isqrt

from rosproto.gateway.chunks import ChunkedMessage

MOST_BYTES = 256 << 10
"""Of a text that a client sends this way: undoing a picture's filters takes up to a microsecond for three."""
MOST_ROWS = 4096
"""Each takes ten microseconds, however short; the picture of a text is about square."""


class PngError(Exception):
    """What a client sent is no such picture; the text is a sentence for it."""


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
    """The message that carries another one, whose JSON text is given, as a picture."""
    return f'{{"op": "png", "data": "{pack(text)}"}}'


def unpack(data: str, most_bytes: int = MOST_BYTES) -> str:
    """The text in a picture.

    Args:
        data: Base64 of a PNG.
        most_bytes: Longest text, and longest picture; compared before memory is taken.

    Raises:
        PngError: It is no such picture, its text is no UTF-8, or one of them is too long.
    """
    from rosproto.numeric.pngfile import decode_png

    if len(data) > most_bytes * 4 // 3 + 4:
        raise PngError(f"the picture has more than the limit of {most_bytes} bytes")
    try:
        pixels = decode_png(binascii.a2b_base64(data), most_bytes // 3, MOST_ROWS)
    except ValueError as error:  # binascii's own is one
        raise PngError(f"no PNG picture in base64: {error}") from None
    if pixels.shape[2] != 3:
        raise PngError(f"the picture has {pixels.shape[2]} channels; expected red, green and blue")
    try:
        return pixels.tobytes().decode("utf-8")
    except UnicodeDecodeError as error:
        raise PngError(f"the picture's bytes are no UTF-8: {error}") from None
