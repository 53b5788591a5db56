"""Encodings of sensor_msgs/Image: their values, channels and colours, and converting between them.

In ROS this is the C++ part of cv_bridge.

Source: OpenCV's numbers for types of arrays; cv_bridge.cpp (which conversions make sense, how depths are
scaled, the texts).
"""

import numpy

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
_UNKNOWN = ("uyvy", "yuv422_yuy2", "yuyv")  # not known to the C++ part of cv_bridge either


def layout(encoding):
    """(depth such as "8U", channels, colour or None).

    Raises:
        RuntimeError: There is no such encoding.
    """
    entry = ENCODINGS.get(encoding)
    if entry is not None and encoding not in _UNKNOWN:
        return {"u1": "8U", "u2": "16U"}[entry.kind], entry.channels, entry.colour
    depth, c, channels = encoding.partition("C")
    if depth in DEPTHS and c and (channels.isdigit() or not channels):
        return depth, int(channels or 1), None
    raise RuntimeError("Unrecognized image encoding [%s]" % encoding)


def getCvType(encoding):
    """OpenCV's number of the type of an encoding's array."""
    depth, channels, _ = layout(encoding)
    return DEPTHS[depth] + ((channels - 1) << 3)


# OpenCV names a pattern by the pixels of its second row.
_BAYER = {"RGGB": "BG", "BGGR": "RG", "GBRG": "GR", "GRBG": "GB"}


def cvtColor2(image, present, wanted):
    """An array in another encoding; always an array of its own.

    Raises:
        RuntimeError: The conversion makes no sense, or an encoding is unknown.
    """
    if not wanted or wanted == present:
        return image.copy()
    depth, channels, colour = layout(present)
    to_depth, to_channels, to_colour = layout(wanted)
    if to_colour is None:
        if channels != to_channels:
            text = "[%s] and [%s] do not have the same number of channel"
            if colour is not None:
                text = (
                    "[%s] is a color format but [%s] is not so they must have the same OpenCV type,"
                    " CV_8UC3, CV16UC1 ...."
                )
            raise RuntimeError(text % (present, wanted))
    elif colour is None:
        raise RuntimeError(
            "[%s] is not a color format. but [%s] is. The conversion does not make sense" % (present, wanted)
        )
    elif colour != to_colour:
        image = _recoloured(image, _code(colour, to_colour, present, wanted))
        if depth == to_depth:
            return image
    return _rescaled(image, depth, to_depth)


def _code(colour, to_colour, present, wanted):
    """Name of OpenCV's conversion."""
    plain = ("GRAY", "RGB", "BGR", "RGBA", "BGRA")
    if to_colour in plain:
        if colour in plain:
            return "%s2%s" % (colour, to_colour)
        if colour == "YUV422":
            return "YUV2%s_UYVY" % to_colour
        if to_colour in ("GRAY", "RGB", "BGR"):
            return "Bayer%s2%s" % (_BAYER[colour.partition("_")[2]], to_colour)
    raise RuntimeError("Unsupported conversion from [%s] to [%s]" % (present, wanted))


def _recoloured(image, code):
    if code in ("RGB2BGR", "BGR2RGB"):
        return image[:, :, ::-1].copy()
    import cv2

    return cv2.cvtColor(image, getattr(cv2, "COLOR_" + code))


def _rescaled(image, depth, to_depth):
    to = numpy.dtype(NUMPY[to_depth])
    scale = {("8", "16"): 65535.0 / 255.0, ("16", "8"): 255.0 / 65535.0}.get((depth[:-1], to_depth[:-1]), 1.0)
    if to.kind == "f":
        return image.astype(to)
    limits = numpy.iinfo(to)
    return numpy.clip(numpy.rint(image * scale), limits.min, limits.max).astype(to)
