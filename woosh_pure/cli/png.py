"""Camera images as PNG: colours as they are, depth as a visible picture or as data."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.numeric import encode_png, picture_order

if TYPE_CHECKING:
    from woosh_pure.values.state import Image

__all__ = ["encode_png", "image_png"]


def image_png(image: Image, *, millimetres: bool = False) -> bytes:
    """A PNG of a camera image; depth is scaled to its own range, near is bright, nothing measured is black.

    Args:
        image: What the camera sent.
        millimetres: True for depth as data: 16-bit grey in mm, 0 where nothing was measured. It looks black.

    Raises:
        ValueError: The encoding cannot be shown.
    """
    pixels = image.pixels
    if image.encoding in ("16UC1", "mono16", "32FC1"):
        from rosproto.numeric import depth_millimetres, visible_depth

        metres = image.depth_metres()
        return encode_png(depth_millimetres(metres) if millimetres else visible_depth(metres))
    order = picture_order(image.encoding)
    return encode_png(pixels if order is None else pixels[..., order])
