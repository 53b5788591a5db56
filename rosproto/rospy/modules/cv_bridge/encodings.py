"""Encodings of sensor_msgs/Image: their values, channels and colours.

Source: sensor_msgs/image_encodings.h, OpenCV's numbers for types of arrays.
"""

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
_COLOURS = {
    "mono8": ("8U", 1, "GRAY"),
    "mono16": ("16U", 1, "GRAY"),
    "bgr8": ("8U", 3, "BGR"),
    "rgb8": ("8U", 3, "RGB"),
    "bgra8": ("8U", 4, "BGRA"),
    "rgba8": ("8U", 4, "RGBA"),
    "bgr16": ("16U", 3, "BGR"),
    "rgb16": ("16U", 3, "RGB"),
    "bgra16": ("16U", 4, "BGRA"),
    "rgba16": ("16U", 4, "RGBA"),
    "yuv422": ("8U", 2, "YUV422"),
}
for _pattern in ("rggb", "bggr", "gbrg", "grbg"):
    _COLOURS["bayer_%s8" % _pattern] = ("8U", 1, "BAYER_" + _pattern.upper())
    _COLOURS["bayer_%s16" % _pattern] = ("16U", 1, "BAYER_" + _pattern.upper())


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
