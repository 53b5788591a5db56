"""sensor_msgs/Image and CompressedImage as PNG; Pillow is needed for the compressed ones alone.

Source: sensor_msgs/image_encodings.h for the encodings, REP 118 for depth images.
"""

from __future__ import annotations

from typing import Any

from .counts import counted
from .graph import CommandError

__all__ = ["IMAGES", "pixels_of", "png_of"]

IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")

# encoding -> numpy type of a channel, channels, order in which channels become L, RGB or RGBA
ENCODINGS: dict[str, tuple[str, int, tuple[int, ...]]] = {
    "mono8": ("u1", 1, (0,)),
    "8UC1": ("u1", 1, (0,)),
    "rgb8": ("u1", 3, (0, 1, 2)),
    "bgr8": ("u1", 3, (2, 1, 0)),
    "8UC3": ("u1", 3, (2, 1, 0)),
    "rgba8": ("u1", 4, (0, 1, 2, 3)),
    "bgra8": ("u1", 4, (2, 1, 0, 3)),
    "8UC4": ("u1", 4, (2, 1, 0, 3)),
    "mono16": ("u2", 1, (0,)),
    "16UC1": ("u2", 1, (0,)),
    "32FC1": ("f4", 1, (0,)),
    **{f"bayer_{order}8": ("u1", 1, (0,)) for order in ("rggb", "bggr", "gbrg", "grbg")},
}


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
    from rosproto.numeric.pngfile import SIGNATURE, encode_png

    if message._type == "sensor_msgs/CompressedImage":
        data = bytes(message.data)
        return data if data.startswith(SIGNATURE) else _converted(data)
    pixels = pixels_of(message)
    if scale_depth and message.encoding in DEPTH:
        from rosproto.numeric.depth import visible_depth

        pixels = visible_depth(pixels / 1000.0)
    return encode_png(pixels)


def _converted(data: bytes) -> bytes:
    import io

    from .bag_export import need

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

    if message.encoding not in ENCODINGS:
        raise CommandError(
            f"an image with encoding {message.encoding!r}; known are {', '.join(sorted(ENCODINGS))}"
        )
    kind, channels, order = ENCODINGS[message.encoding]
    dtype = np.dtype((">" if message.is_bigendian else "<") + kind)
    height, width, row = message.height, message.width, message.width * channels * dtype.itemsize
    data = np.frombuffer(bytes(message.data), np.uint8)
    if message.step < row or len(data) < height * message.step:
        raise CommandError(
            f"an image of {width}x{height} {message.encoding} with step {message.step} needs "
            f"{counted(height * max(row, message.step), 'byte')}, but has {len(data)}"
        )
    rows = data[: height * message.step].reshape(height, message.step)[:, :row]
    pixels = np.ascontiguousarray(rows).view(dtype).reshape(height, width, channels)[:, :, list(order)]
    if kind == "f4":
        from rosproto.numeric.depth import depth_millimetres

        return depth_millimetres(pixels[:, :, 0])
    pixels = pixels.astype(dtype.newbyteorder("="))
    return np.ascontiguousarray(pixels[:, :, 0] if channels == 1 else pixels)
