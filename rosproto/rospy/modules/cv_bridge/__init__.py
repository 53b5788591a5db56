"""cv_bridge: images as arrays. OpenCV is only needed to convert colours and to compress."""

from .core import CvBridge, CvBridgeError

__all__ = ["CvBridge", "CvBridgeError", "getCvType"]


def __getattr__(name):
    if name != "getCvType":
        raise AttributeError("module 'cv_bridge' has no attribute %r" % name)
    from .encodings import cv_type

    return cv_type
