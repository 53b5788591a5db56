"""Encodings of sensor_msgs/Image: their values, channels and colours.

Source: OpenCV's numbers for types of arrays.
"""

from rosproto.numeric.images import ENCODINGS

DEPTHS = {"8U": 0, "8S": 1, "16U": 2, "16S": 3, "32S": 4, "32F": 5, "64F": 6}
NUMPY = {
    "8U": "uint8",
    "8S": "int8",
    "16U": "uint16",
    "16S": "int16",
    "32S": "int32",
    "32F": "float32",
    "64F": "float64",
}
_DEPTH = {"u1": "8U", "u2": "16U"}
_COLOURS = {
    name: (_DEPTH[entry.kind], entry.channels, entry.colour)
    for name, entry in ENCODINGS.items()
    if name not in ("uyvy", "yuv422_yuy2", "yuyv")  # not known to the C++ part of cv_bridge either
}


def layout(encoding):
    """(depth such as "8U", channels, colour or None).

    Raises:
        RuntimeError: There is no such encoding.
    """
    if encoding in _COLOURS:
        return _COLOURS[encoding]
    depth, c, channels = encoding.partition("C")
    if depth in DEPTHS and c and (channels.isdigit() or not channels):
        return depth, int(channels or 1), None
    raise RuntimeError("Unrecognized image encoding [%s]" % encoding)


def cv_type(encoding):
    """OpenCV's number of the type of an encoding's array."""
    depth, channels, _ = layout(encoding)
    return DEPTHS[depth] + ((channels - 1) << 3)
