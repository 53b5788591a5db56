"""Images and arrays."""

from __future__ import annotations

import numpy as np
import pytest

from rosproto.codec import decode, encode, message_class
from rosproto.numeric import array_to_image, compressed_image_bytes, image_to_array

Image = message_class("sensor_msgs/Image")


@pytest.mark.parametrize(
    ("encoding", "shape", "dtype"),
    [
        ("rgb8", (4, 5, 3), "u1"),
        ("bgr8", (4, 5, 3), "u1"),
        ("rgba8", (4, 5, 4), "u1"),
        ("bgra16", (4, 5, 4), "u2"),
        ("mono8", (4, 5), "u1"),
        ("mono16", (4, 5), "u2"),
        ("16UC1", (4, 5), "u2"),
        ("32FC1", (4, 5), "f4"),
        ("64FC2", (4, 5, 2), "f8"),
        ("8UC3", (4, 5, 3), "u1"),
        ("32SC4", (4, 5, 4), "i4"),
        ("8UC", (4, 5), "u1"),
        ("bayer_rggb8", (4, 5), "u1"),
        ("bayer_grbg16", (4, 5), "u2"),
        ("yuv422", (4, 6, 2), "u1"),
    ],
)
def test_arrays_survive_the_wire(encoding: str, shape: tuple[int, ...], dtype: str) -> None:
    """Shape, dtype and values come back, as a view of the received bytes."""
    array = np.arange(np.prod(shape)).astype(dtype).reshape(shape)
    received = decode(Image, encode(array_to_image(array, encoding)))
    back = image_to_array(received)
    assert back.shape == shape
    assert back.dtype == np.dtype(dtype)
    assert np.array_equal(back, array)
    assert np.shares_memory(back, received.data)
    assert not back.flags.writeable


def test_padded_rows_and_big_endian_data() -> None:
    """step may exceed a row; multi-byte values may be big-endian."""
    rows = np.zeros((2, 8), "u1")
    rows[:, :4] = [[0, 1, 0, 2], [0, 3, 0, 4]]
    image = Image(height=2, width=2, step=8, encoding="mono16", is_bigendian=1, data=rows.reshape(-1))
    assert image_to_array(image).tolist() == [[1, 2], [3, 4]]
    image.data = rows.tobytes()[:12]  # the last row's padding may be missing
    assert image_to_array(image).tolist() == [[1, 2], [3, 4]]
    image.data = rows.tobytes()[:11]
    with pytest.raises(ValueError, match="11 bytes are there"):
        image_to_array(image)


def test_errors_say_what_fits() -> None:
    """Unknown encodings, wrong shapes, wrong dtypes."""
    for encoding in ("rgb9", "8FC1", "64UC1x", "jpeg", ""):
        with pytest.raises(ValueError, match="is unknown; known are mono8"):
            image_to_array(Image(encoding=encoding))
    with pytest.raises(ValueError, match=r"rgb8 takes \(H, W, 3\) uint8, not \(2, 2\) uint8"):
        array_to_image(np.zeros((2, 2), "u1"), "rgb8")
    with pytest.raises(ValueError, match=r"mono16 takes \(H, W\) uint16, not \(2, 2\) float64"):
        array_to_image(np.zeros((2, 2)), "mono16")


def test_empty_images() -> None:
    """No pixels, but a shape."""
    assert image_to_array(Image(encoding="rgb8")).shape == (0, 0, 3)
    assert image_to_array(Image(encoding="mono8", height=2)).shape == (2, 0)


def test_strided_arrays_become_images() -> None:
    """A crop is copied together."""
    pixels = np.arange(300).astype("u1").reshape(10, 10, 3)
    image = array_to_image(pixels[2:4, ::2], "rgb8", header=message_class("std_msgs/Header")(frame_id="cam"))
    assert np.array_equal(image_to_array(image), pixels[2:4, ::2])
    assert image.header.frame_id == "cam"


def test_compressed_images_are_files() -> None:
    """The bytes as they are, in both value styles."""
    cls = message_class("sensor_msgs/CompressedImage")
    data = encode(cls(format="jpeg", data=b"\xff\xd8\xff"))
    for value_style in ("numpy", "rospy"):
        received = decode(message_class("sensor_msgs/CompressedImage", value_style=value_style), data)
        assert compressed_image_bytes(received) == b"\xff\xd8\xff"
