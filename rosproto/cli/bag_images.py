"""sensor_msgs/Image and CompressedImage as Pillow images.

Source: sensor_msgs/image_encodings.h for the encodings, REP 118 for depth images.
"""

from __future__ import annotations

from typing import Any

from .graph import CommandError

__all__ = ["IMAGES", "picture"]

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


def picture(message: Any, pillow: Any) -> Any:
    """The image of a message; Bayer patterns as they are, depth in metres (32FC1) as 16-bit millimetres.

    Raises:
        CommandError: An encoding that is not known, or data that do not fit the size.
    """
    if message._type == "sensor_msgs/CompressedImage":
        import io

        return pillow.open(io.BytesIO(bytes(message.data)))
    return pillow.fromarray(_pixels(message))


def _pixels(message: Any) -> Any:
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
            f"{height * max(row, message.step)} bytes, but has {len(data)}"
        )
    rows = data[: height * message.step].reshape(height, message.step)[:, :row]
    pixels = np.ascontiguousarray(rows).view(dtype).reshape(height, width, channels)[:, :, list(order)]
    if kind == "f4":
        return np.clip(np.nan_to_num(pixels[:, :, 0]) * 1000.0, 0, 65535).astype(np.uint16)
    pixels = pixels.astype(dtype.newbyteorder("="))
    return np.ascontiguousarray(pixels[:, :, 0] if channels == 1 else pixels)
