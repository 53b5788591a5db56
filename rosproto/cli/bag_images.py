"""sensor_msgs/Image and CompressedImage as PNG; Pillow is needed for the compressed ones alone.

Source: REP 118 for depth images.
"""

from __future__ import annotations

from typing import Any

from .connection import CommandError
from .counts import counted

__all__ = ["IMAGES", "pixels_of", "png_of"]

IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")

DEPTH = ("16UC1", "32FC1")


def png_of(message: Any, *, scale_depth: bool = False) -> bytes:
    """The PNG file of a message; Bayer patterns as they are, depth as 16-bit grey in mm.

    Args:
        message: A sensor_msgs/Image or CompressedImage.
        scale_depth: True scales each depth image to its own range, for looking at.

    Raises:
        CommandError: An encoding that is not known, data that do not fit the size, or Pillow is needed and
            absent.
    """
    from rosproto.numeric.pngfile import encode_png, is_png

    if message._type == "sensor_msgs/CompressedImage":
        data = bytes(message.data)
        return data if is_png(data) else _converted(data)
    pixels = pixels_of(message)
    if scale_depth and message.encoding in DEPTH:
        from rosproto.numeric.depth import visible_depth

        pixels = visible_depth(pixels / 1000.0)
    return encode_png(pixels)


def _converted(data: bytes) -> bytes:
    import io

    from .optional import need

    pillow = need("PIL.Image", "Pillow", "cli")
    file = io.BytesIO()
    try:
        pillow.open(io.BytesIO(data)).save(file, "PNG")
    except (OSError, ValueError) as error:
        raise CommandError(f"a compressed image that cannot be read: {error}") from error
    return file.getvalue()


def pixels_of(message: Any) -> Any:
    """The pixels of a sensor_msgs/Image, in the order of a picture; metres (32FC1) become millimetres."""
    import numpy as np

    from rosproto.numeric.depth import depth_millimetres
    from rosproto.numeric.encodings import PICTURES, picture_order
    from rosproto.numeric.images import image_to_array

    if message.encoding not in PICTURES:
        raise CommandError(
            f"an image with encoding {message.encoding!r}; known are {', '.join(sorted(PICTURES))}"
        )
    try:
        pixels = image_to_array(message)
    except ValueError as error:
        found = counted(len(message.data), "byte")
        raise CommandError(f"an image should have all its rows, but has {found}: {error}") from error
    if message.encoding == "32FC1":
        return depth_millimetres(pixels)
    order = picture_order(message.encoding)
    pixels = pixels if order is None else pixels[:, :, order]
    return np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("="))
