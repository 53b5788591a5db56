"""image_geometry: pixels and rays of cameras (wiki.ros.org/image_geometry)."""

from .cameramodels import PinholeCameraModel, StereoCameraModel

__all__ = ["PinholeCameraModel", "StereoCameraModel"]
