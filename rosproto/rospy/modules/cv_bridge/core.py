"""CvBridge: sensor_msgs/Image and CompressedImage to arrays and back."""

import sys

import numpy
from sensor_msgs.msg import CompressedImage, Image

from .boost.cv_bridge_boost import DEPTHS, NUMPY, cvtColor2, getCvType


class CvBridgeError(TypeError):
    """An image cannot be converted."""


def _converted(image, present, wanted):
    if wanted == "passthrough":
        return image
    try:
        return cvtColor2(image, present, wanted)
    except RuntimeError as error:
        raise CvBridgeError(error) from None


def _require_array(image):
    if not isinstance(image, (numpy.ndarray, numpy.generic)):
        raise TypeError("Your input type is not a numpy array")


class CvBridge:
    """Converts both ways.

    Attributes:
        cvtype_to_name: "8UC3" and so on, by OpenCV's numbers.
        cvdepth_to_numpy_depth: "uint8" and so on, by OpenCV's numbers of depths.
        numpy_type_to_cvtype: "8U" by "uint8", and the other way round.
    """

    def __init__(self):
        self.cvtype_to_name = {
            number + ((channels - 1) << 3): "%sC%d" % (depth, channels)
            for depth, number in DEPTHS.items()
            for channels in (1, 2, 3, 4)
        }
        self.cvdepth_to_numpy_depth = {number: NUMPY[depth] for depth, number in DEPTHS.items()}
        self.numpy_type_to_cvtype = {kind: depth for depth, kind in NUMPY.items()} | NUMPY

    def dtype_with_channels_to_cvtype2(self, dtype, n_channels):
        """ "8UC3" of a dtype and a number of channels."""
        return "%sC%d" % (self.numpy_type_to_cvtype[dtype.name], n_channels)

    def cvtype2_to_dtype_with_channels(self, cvtype):
        """("uint8", 3) of OpenCV's number."""
        return self.cvdepth_to_numpy_depth[cvtype & 7], (cvtype >> 3) + 1

    def encoding_to_cvtype2(self, encoding):
        """OpenCV's number of an encoding."""
        try:
            return getCvType(encoding)
        except RuntimeError as error:
            raise CvBridgeError(error) from None

    def encoding_to_dtype_with_channels(self, encoding):
        """("uint8", 3) of an encoding."""
        return self.cvtype2_to_dtype_with_channels(self.encoding_to_cvtype2(encoding))

    def imgmsg_to_cv2(self, img_msg, desired_encoding="passthrough"):
        """An array (height, width[, channels]) of an Image, read-only when nothing had to be converted.

        Raises:
            CvBridgeError: An encoding is unknown, or the two cannot be converted into each other.
        """
        kind, channels = self.encoding_to_dtype_with_channels(img_msg.encoding)
        kind = numpy.dtype(kind).newbyteorder(">" if img_msg.is_bigendian else "<")
        data = img_msg.data
        data = data.encode() if isinstance(data, str) else bytes(data) if isinstance(data, list) else data
        shape, strides = (img_msg.height, img_msg.width), (img_msg.step, kind.itemsize * channels)
        if channels > 1:
            shape, strides = (*shape, channels), (*strides, kind.itemsize)
        row = img_msg.width * channels * kind.itemsize
        if img_msg.step <= row:  # rows without padding, whatever the step says
            strides = (row, *strides[1:])
        image = numpy.ndarray(shape, kind, data, strides=strides)
        if img_msg.is_bigendian == (sys.byteorder == "little"):
            image = image.astype(kind.newbyteorder("="))
        elif img_msg.step > row:
            image = numpy.ascontiguousarray(image)
        return _converted(image, img_msg.encoding, desired_encoding)

    def cv2_to_imgmsg(self, cvim, encoding="passthrough", header=None):
        """An Image of an array.

        Raises:
            TypeError: It is no array.
            CvBridgeError: The encoding does not fit it.
        """
        _require_array(cvim)
        message = Image(height=cvim.shape[0], width=cvim.shape[1])
        if header is not None:
            message.header = header
        own = self.dtype_with_channels_to_cvtype2(cvim.dtype, 1 if cvim.ndim < 3 else cvim.shape[2])
        message.encoding = own if encoding == "passthrough" else encoding
        if encoding != "passthrough" and self.cvtype_to_name[self.encoding_to_cvtype2(encoding)] != own:
            raise CvBridgeError(
                "encoding specified as %s, but image has incompatible type %s" % (encoding, own)
            )
        message.is_bigendian = True if cvim.dtype.byteorder == ">" else message.is_bigendian
        message.data = cvim.tobytes()
        message.step = len(message.data) // message.height
        return message

    def compressed_imgmsg_to_cv2(self, cmprs_img_msg, desired_encoding="passthrough"):
        """An array of a CompressedImage; None when its bytes are no picture."""
        import cv2

        data = cmprs_img_msg.data
        image = cv2.imdecode(numpy.ndarray((1, len(data)), "uint8", data), cv2.IMREAD_UNCHANGED)
        return _converted(image, "bgr8", desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim, dst_format="jpg"):
        """A CompressedImage of an array: "jpg", "png" and what else OpenCV writes."""
        _require_array(cvim)
        import cv2

        return CompressedImage(format=dst_format, data=cv2.imencode("." + dst_format, cvim)[1].tobytes())
