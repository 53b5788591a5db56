"""cv_bridge: images as arrays. OpenCV is only needed to convert colours and to compress."""

__all__ = ["CvBridge", "CvBridgeError"]

_TYPES = {"8UC": "u1", "8SC": "i1", "16UC": "u2", "16SC": "i2", "32SC": "i4", "32FC": "f4", "64FC": "f8"}
_NAMED = {
    "mono8": ("u1", 1),
    "mono16": ("u2", 1),
    "bgr8": ("u1", 3),
    "rgb8": ("u1", 3),
    "bgra8": ("u1", 4),
    "rgba8": ("u1", 4),
    "bgr16": ("u2", 3),
    "rgb16": ("u2", 3),
    "bgra16": ("u2", 4),
    "rgba16": ("u2", 4),
    "yuv422": ("u1", 2),
    "bayer_rggb8": ("u1", 1),
    "bayer_bggr8": ("u1", 1),
    "bayer_gbrg8": ("u1", 1),
    "bayer_grbg8": ("u1", 1),
}


class CvBridgeError(TypeError):
    """An image cannot be converted."""


def _layout(encoding):
    """numpy type and channels of an encoding."""
    if encoding in _NAMED:
        return _NAMED[encoding]
    for prefix, code in _TYPES.items():
        if encoding.startswith(prefix) and encoding[len(prefix) :].isdigit():
            return code, int(encoding[len(prefix) :])
    raise CvBridgeError("Unrecognized image encoding [%s]" % encoding)


class CvBridge:
    """Converts both ways."""

    def imgmsg_to_cv2(self, img_msg, desired_encoding="passthrough"):
        """An array (height, width, channels) of a sensor_msgs/Image; a copy when colours are converted."""
        import numpy

        code, channels = _layout(img_msg.encoding)
        kind = numpy.dtype(code).newbyteorder(">" if img_msg.is_bigendian else "<")
        width = img_msg.width * channels
        rows = numpy.ndarray(
            (img_msg.height, width), kind, bytes(img_msg.data), strides=(img_msg.step, kind.itemsize)
        )
        image = rows.reshape(img_msg.height, img_msg.width, channels)
        image = (image[:, :, 0] if channels == 1 else image).astype(kind.newbyteorder("="))
        return self._converted(image, img_msg.encoding, desired_encoding)

    def cv2_to_imgmsg(self, cvim, encoding="passthrough", header=None):
        """A sensor_msgs/Image of an array."""
        import numpy
        from sensor_msgs.msg import Image

        cvim = numpy.ascontiguousarray(cvim)
        channels = 1 if cvim.ndim == 2 else cvim.shape[2]
        code = cvim.dtype.str[1:]
        named = next((prefix for prefix, kind in _TYPES.items() if kind == code), None)
        if named is None:
            raise CvBridgeError("no encoding for arrays of %s" % cvim.dtype)
        own = "%s%d" % (named, channels)
        if encoding not in ("passthrough", own) and _layout(encoding) != (code, channels):
            raise CvBridgeError(
                "encoding specified as %s, but image has incompatible type %s" % (encoding, own)
            )
        message = Image(height=cvim.shape[0], width=cvim.shape[1])
        message.encoding = own if encoding == "passthrough" else encoding
        message.step = cvim.shape[1] * channels * cvim.dtype.itemsize
        message.is_bigendian = int(cvim.dtype.byteorder == ">")
        message.data = cvim.tobytes()
        if header is not None:
            message.header = header
        return message

    def compressed_imgmsg_to_cv2(self, cmprs_img_msg, desired_encoding="passthrough"):
        """An array of a sensor_msgs/CompressedImage."""
        import cv2
        import numpy

        image = cv2.imdecode(numpy.frombuffer(bytes(cmprs_img_msg.data), "u1"), cv2.IMREAD_UNCHANGED)
        return self._converted(image, "mono8" if image.ndim == 2 else "bgr8", desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim, dst_format="jpg"):
        """A sensor_msgs/CompressedImage of an array."""
        import cv2
        from sensor_msgs.msg import CompressedImage

        return CompressedImage(format=dst_format, data=cv2.imencode("." + dst_format, cvim)[1].tobytes())

    @staticmethod
    def _converted(image, present, wanted):
        if wanted in ("passthrough", present):
            return image
        if {present, wanted} in ({"rgb8", "bgr8"}, {"rgb16", "bgr16"}):
            return image[:, :, ::-1].copy()
        if _layout(present) == _layout(wanted) and not (present in _NAMED and wanted in _NAMED):
            return image
        import cv2

        names = {"mono": "GRAY", "bgr": "BGR", "rgb": "RGB", "bgra": "BGRA", "rgba": "RGBA"}
        pair = [names.get(name.rstrip("0123456789")) for name in (present, wanted)]
        code = getattr(cv2, "COLOR_%s2%s" % tuple(pair), None) if None not in pair else None
        if code is None:
            raise CvBridgeError("cannot convert %s to %s" % (present, wanted))
        return cv2.cvtColor(image, code)
