# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of bond as classes."""

from typing import ClassVar as _ClassVar

import msgdefs.std_msgs.msg as _std_msgs
from rosproto.codec import Message as _Message

class Constants(_Message):
    """bond/Constants

    float32 DEAD_PUBLISH_PERIOD=0.05
    float32 DEFAULT_CONNECT_TIMEOUT=10.0
    float32 DEFAULT_HEARTBEAT_TIMEOUT=4.0
    float32 DEFAULT_DISCONNECT_TIMEOUT=2.0
    float32 DEFAULT_HEARTBEAT_PERIOD=1.0
    string DISABLE_HEARTBEAT_TIMEOUT_PARAM=/bond_disable_heartbeat_timeout
    """

    DEAD_PUBLISH_PERIOD: _ClassVar[float] = 0.05
    DEFAULT_CONNECT_TIMEOUT: _ClassVar[float] = 10.0
    DEFAULT_HEARTBEAT_TIMEOUT: _ClassVar[float] = 4.0
    DEFAULT_DISCONNECT_TIMEOUT: _ClassVar[float] = 2.0
    DEFAULT_HEARTBEAT_PERIOD: _ClassVar[float] = 1.0
    DISABLE_HEARTBEAT_TIMEOUT_PARAM: _ClassVar[str] = '/bond_disable_heartbeat_timeout'
    def __init__(self) -> None: ...

class Status(_Message):
    """bond/Status

    # Sent by each end of a bond, on the bond's topic.

    Header header
    string id  # of the bond
    string instance_id  # of the end that sends this
    bool active
    float32 heartbeat_timeout  # s
    float32 heartbeat_period  # s
    """

    header: _std_msgs.Header
    id: str
    instance_id: str
    active: bool
    heartbeat_timeout: float
    heartbeat_period: float
    def __init__(
        self,
        header: _std_msgs.Header = ...,
        id: str = ...,
        instance_id: str = ...,
        active: bool = ...,
        heartbeat_timeout: float = ...,
        heartbeat_period: float = ...,
    ) -> None: ...
