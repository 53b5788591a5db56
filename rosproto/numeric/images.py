"""sensor_msgs/Image as arrays, and back: encodings, pixels, and depth images made visible."""

from __future__ import annotations

import re
import sys
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rosproto.codec import DynamicMessage, Message, message_class
from rosproto.sentence import both, say

if TYPE_CHECKING:
    from msgdefs.sensor_msgs.msg import CompressedImage, Image


def image_to_array(image: Image | DynamicMessage) -> NDArray[Any]:
    """The pixels of a sensor_msgs/Image.

    Args:
        image: The message; its encoding may be rgb8, bgr8, rgba8, bgra8 (and 16), mono8, mono16, bayer_*,
            yuv422 and its like, or 8UC1 ... 64FC4.

    Returns:
        (H, W) for one channel, (H, W, C) for several, channels in the order of the encoding's name; uint8,
        uint16 and so on, big-endian if the message is. Row 0 is the top. A view of `image.data`, also when
        rows are padded.

    Raises:
        ValueError: The encoding is unknown, or the data are too short.
    """
    name, channels, _ = pixel_layout(image.encoding)
    dtype = np.dtype(name).newbyteorder(">" if image.is_bigendian else "<")
    height, width, step = image.height, image.width, image.step
    row = width * channels * dtype.itemsize
    data = octets(image.data)
    if step < row or (data.size < (height - 1) * step + row and height):
        raise ValueError(
            f"{width}x{height} {image.encoding} takes {row} bytes in each of {height} rows, "
            f"but step is {step} and {data.size} bytes are there"
        )
    shape, strides = (height, width, channels), (step, channels * dtype.itemsize, dtype.itemsize)
    if height * width == 0:
        pixels: NDArray[Any] = np.empty(shape, dtype)
    else:
        pixels = np.ndarray(shape, dtype, data, strides=strides)
    return pixels[:, :, 0] if channels == 1 else pixels


def array_to_image(array: NDArray[np.generic], encoding: str, *, header: Message | None = None) -> Any:
    """A sensor_msgs/Image of an array.

    Args:
        array: (H, W) or (H, W, C), of the encoding's dtype; nothing is converted or scaled.
        encoding: As for `image_to_array`.
        header: A std_msgs/Header to use; a new one by default.

    Returns:
        The message. Its data are a view of a contiguous array, so change neither before it is published.

    Raises:
        ValueError: Shape or dtype do not fit the encoding.
    """
    name, channels, _ = pixel_layout(encoding)
    array = np.asarray(array)
    found = array.shape[2] if array.ndim == 3 else 1
    if array.ndim not in (2, 3) or found != channels or array.dtype.newbyteorder("=") != np.dtype(name):
        raise ValueError(
            f"{encoding} takes (H, W{', ' + str(channels) if channels > 1 else ''}) {np.dtype(name)}, "
            f"not {array.shape} {array.dtype}"
        )
    big = array.dtype.byteorder == ">" or (array.dtype.byteorder == "=" and sys.byteorder == "big")
    return message_class("sensor_msgs/Image")(
        header=header,
        height=array.shape[0],
        width=array.shape[1],
        encoding=encoding,
        is_bigendian=int(big),
        step=array.shape[1] * channels * array.itemsize,
        data=np.ascontiguousarray(array).reshape(-1).view(np.uint8),
    )


def compressed_image_bytes(image: CompressedImage | DynamicMessage) -> bytes:
    """The JPEG or PNG file in a sensor_msgs/CompressedImage, for any image library; a copy."""
    return octets(image.data).tobytes()


def octets(data: ArrayLike) -> NDArray[np.uint8]:
    """A flat uint8 array of a uint8[] field: a view of arrays and bytes, a copy of lists."""
    if isinstance(data, (bytes, bytearray, memoryview)):
        return np.frombuffer(data, np.uint8) if len(data) else np.empty(0, np.uint8)
    array: NDArray[np.uint8] = np.asarray(data, np.uint8).reshape(-1)
    return array


# -- encodings ----------------------------------------------------------------------------------------------
# Encodings of sensor_msgs/Image: the values of a pixel and their colours. Pure.
#
# Source: sensor_msgs/image_encodings.h; OpenCV's colour order for those without one (8UC3 is BGR).


class PixelLayout(NamedTuple):
    """numpy's type of one value ("u1"), values per pixel, and their colour; "" if unnamed."""

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
"""The named encodings; "16UC1" and similar ones are parsed."""
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
"""The encodings of pictures, and the order of their values for grey, RGB or RGBA."""


def pixel_layout(encoding: str) -> PixelLayout:
    """The layout of a pixel.

    Raises:
        ValueError: The encoding is unknown.
    """
    known = ENCODINGS.get(encoding)
    if known is not None:
        return known
    match = _BY_RULE.fullmatch(encoding)
    if match is None or ((match[2] == "F") != (match[1] in ("32", "64")) and match[1] != "32"):
        others = say("known are {names} and those like 16UC1, 32FC1", names=list(ENCODINGS))
        raise ValueError(both(say("image encoding {name!r} is unknown", name=encoding[:40]), others))
    return PixelLayout({"U": "u", "S": "i", "F": "f"}[match[2]] + str(int(match[1]) // 8), int(match[3] or 1))


def picture_order(encoding: str) -> list[int] | None:
    """Index of channels that makes grey, RGB or RGBA; None if they are in that order."""
    order = PICTURES.get(encoding, (0,))
    return None if order == tuple(range(len(order))) else list(order)


# -- depth --------------------------------------------------------------------------------------------------


_NEAR, _FAR = 255, 40
"""Grey values; 0 means not measured."""


def depth_millimetres(metres: NDArray[np.floating]) -> NDArray[np.uint16]:
    """(height, width) uint16 in mm; 0 where nothing was measured, 65535 where it is too far."""
    found = np.nan_to_num(metres.astype(np.float64) * 1000.0, nan=0.0, posinf=0.0, neginf=0.0)
    return np.clip(np.rint(found), 0, 65535).astype(np.uint16)


def visible_depth(metres: NDArray[np.floating]) -> NDArray[np.uint8]:
    """(height, width) uint8, scaled to the range in the image: nearest white, farthest dark, unmeasured
    black.

    Args:
        metres: (height, width) in m; NaN, infinity, zero and negative values are not measured.
    """
    depth = metres.astype(np.float64)
    seen = np.isfinite(depth) & (depth > 0.0)
    grey = np.zeros(depth.shape, np.uint8)
    if not seen.any():
        return grey
    near, far = float(depth[seen].min()), float(depth[seen].max())
    share = (depth[seen] - near) / (far - near) if far > near else np.zeros(int(seen.sum()))
    grey[seen] = np.rint(_NEAR - share * (_NEAR - _FAR)).astype(np.uint8)
    return grey
