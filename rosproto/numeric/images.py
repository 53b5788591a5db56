"""sensor_msgs/Image and arrays."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from rosproto.codec import message_class
from rosproto.numeric.buffers import octets
from rosproto.numeric.encodings import pixel_layout

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["array_to_image", "compressed_image_bytes", "image_to_array"]


def image_to_array(image: Any) -> NDArray[Any]:
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
    import numpy as np

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


def array_to_image(array: NDArray[Any], encoding: str, *, header: Any = None) -> Any:
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
    import numpy as np

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


def compressed_image_bytes(image: Any) -> bytes:
    """The JPEG or PNG file inside a sensor_msgs/CompressedImage, for any image library; a copy."""
    return octets(image.data).tobytes()
