"""Encodings of sensor_msgs/Image: the values of a pixel, and the colours they mean. Pure.

Source: sensor_msgs/image_encodings.h; OpenCV's colour order for those without one (8UC3 is BGR).
"""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["ENCODINGS", "PICTURES", "PixelLayout", "picture_order", "pixel_layout"]


class PixelLayout(NamedTuple):
    """numpy's kind of one value ("u1"), values in a pixel, and their colour; "" when no name tells it."""

    kind: str
    channels: int
    colour: str = ""


_PATTERNS = ("rggb", "bggr", "gbrg", "grbg")
ENCODINGS: dict[str, PixelLayout] = {
    f"{name}{bits}": PixelLayout(f"u{bits // 8}", channels, colour)
    for bits in (8, 16)
    for name, channels, colour in (
        ("mono", 1, "GRAY"),
        *((order, len(order), order.upper()) for order in ("rgb", "bgr", "rgba", "bgra")),
        *((f"bayer_{pattern}", 1, f"BAYER_{pattern.upper()}") for pattern in _PATTERNS),
    )
}
"""The encodings with names; "16UC1" and its like are read by rule."""
# Two octets per pixel, Y and in turn U or V: yuv422 and uyvy are U Y V Y, the others Y U Y V.
ENCODINGS |= {name: PixelLayout("u1", 2, "YUV422") for name in ("yuv422", "uyvy")}
ENCODINGS |= {name: PixelLayout("u1", 2, "YUV422_YUY2") for name in ("yuv422_yuy2", "yuyv")}

_BY_RULE = re.compile(r"(8|16|32|64)([USF])C(\d{0,3})")

_ORDERS = {"GRAY": (0,), "RGB": (0, 1, 2), "BGR": (2, 1, 0), "RGBA": (0, 1, 2, 3), "BGRA": (2, 1, 0, 3)}
PICTURES: dict[str, tuple[int, ...]] = {
    **{name: _ORDERS[entry.colour] for name, entry in ENCODINGS.items() if entry.colour in _ORDERS},
    **{f"bayer_{pattern}8": (0,) for pattern in _PATTERNS},
    "8UC1": (0,),
    "8UC3": (2, 1, 0),
    "8UC4": (2, 1, 0, 3),
    "16UC1": (0,),
    "32FC1": (0,),
}
"""The encodings that make a picture, and the order in which their values become grey, RGB or RGBA."""


def pixel_layout(encoding: str) -> PixelLayout:
    """What a pixel is made of.

    Raises:
        ValueError: The encoding is unknown.
    """
    known = ENCODINGS.get(encoding)
    if known is not None:
        return known
    match = _BY_RULE.fullmatch(encoding)
    if match is None or ((match[2] == "F") != (match[1] in ("32", "64")) and match[1] != "32"):
        raise ValueError(
            f"image encoding {encoding[:40]!r} is unknown; known are {', '.join(ENCODINGS)} "
            "and those like 16UC1, 32FC1"
        )
    return PixelLayout({"U": "u", "S": "i", "F": "f"}[match[2]] + str(int(match[1]) // 8), int(match[3] or 1))


def picture_order(encoding: str) -> list[int] | None:
    """The order in which values become grey, RGB or RGBA, as an index of channels; None when it is theirs."""
    order = PICTURES.get(encoding, (0,))
    return None if order == tuple(range(len(order))) else list(order)
