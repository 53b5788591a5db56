# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of sensor_msgs as classes."""

from typing import TypeAlias as _TypeAlias

import msgdefs.sensor_msgs.msg as _sensor_msgs
from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType

class SetCameraInfoRequest(_Message):
    """sensor_msgs/SetCameraInfoRequest

    # Store a calibration in the camera.

    CameraInfo camera_info
    """

    camera_info: _sensor_msgs.CameraInfo
    def __init__(
        self,
        camera_info: _sensor_msgs.CameraInfo = ...,
    ) -> None: ...

class SetCameraInfoResponse(_Message):
    """sensor_msgs/SetCameraInfoResponse

    bool success
    string status_message
    """

    success: bool
    status_message: str
    def __init__(
        self,
        success: bool = ...,
        status_message: str = ...,
    ) -> None: ...

class SetCameraInfo(_ServiceType):
    """sensor_msgs/SetCameraInfo
    """

    Request: _TypeAlias = SetCameraInfoRequest
    Response: _TypeAlias = SetCameraInfoResponse
