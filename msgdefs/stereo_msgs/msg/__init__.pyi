# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of stereo_msgs as classes."""

import msgdefs.sensor_msgs.msg as _sensor_msgs
import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class DisparityImage(_Message):
    """stereo_msgs/DisparityImage

    # A disparity image: z = f * T / disparity.

    Header header
    sensor_msgs/Image image                    # disparity in pixels, 32FC1
    float32 f                                  # focal length, pixels
    float32 T                                  # baseline, m
    sensor_msgs/RegionOfInterest valid_window  # where disparities were computed
    float32 min_disparity                      # smaller ones are not valid
    float32 max_disparity                      # larger ones are not valid
    float32 delta_d                            # smallest step
    """

    header: _std_msgs.Header
    image: _sensor_msgs.Image
    f: float
    T: float
    valid_window: _sensor_msgs.RegionOfInterest
    min_disparity: float
    max_disparity: float
    delta_d: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        image: _sensor_msgs.Image = ...,
        f: float = ...,
        T: float = ...,
        valid_window: _sensor_msgs.RegionOfInterest = ...,
        min_disparity: float = ...,
        max_disparity: float = ...,
        delta_d: float = ...,
    ) -> None: ...
