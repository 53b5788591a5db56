"""image_geometry: pixels and rays of cameras. Programs import the module inside, too, as in ROS."""

from .cameramodels import PinholeCameraModel, StereoCameraModel
