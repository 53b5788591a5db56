# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of tf2_web_republisher as classes."""

from collections.abc import Sequence as _Sequence
from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType
from rosproto.time import Duration as _Duration

class RepublishTFsRequest(_Message):
    """tf2_web_republisher/RepublishTFsRequest

    # As the action TFSubscription, on a topic of its own (TFArray).
    string[] source_frames
    string target_frame
    float32 angular_thres   # rad
    float32 trans_thres     # m
    float32 rate            # Hz
    duration timeout        # that the topic stays without a subscriber
    """

    source_frames: list[str]
    target_frame: str
    angular_thres: float
    trans_thres: float
    rate: float
    timeout: _Duration
    def __init__(
        self,
        source_frames: _Sequence[str] = ...,
        target_frame: str = ...,
        angular_thres: float = ...,
        trans_thres: float = ...,
        rate: float = ...,
        timeout: _Duration = ...,
    ) -> None: ...

class RepublishTFsResponse(_Message):
    """tf2_web_republisher/RepublishTFsResponse

    string topic_name
    """

    topic_name: str
    def __init__(
        self,
        topic_name: str = ...,
    ) -> None: ...

class RepublishTFs(_ServiceType):
    """tf2_web_republisher/RepublishTFs
    """

    Request: _TypeAlias = RepublishTFsRequest
    Response: _TypeAlias = RepublishTFsResponse
