"""cv_bridge: images as arrays. OpenCV is only needed to convert colours and to compress."""

from .boost.cv_bridge_boost import getCvType
from .core import CvBridge, CvBridgeError
