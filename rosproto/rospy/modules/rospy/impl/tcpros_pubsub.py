"""rospy.impl.tcpros_pubsub: the names that programs import from it."""

from . import _unserved
from ._unserved import TCPROSTransport, TCPROSTransportProtocol
from .transport import ProtocolHandler

__all__ = [
    "QueuedConnection",
    "TCPROSHandler",
    "TCPROSPub",
    "TCPROSSub",
    "TCPROSTransport",
    "check_if_still_publisher",
    "robust_connect_subscriber",
]

_HERE = "rospy.impl.tcpros_pubsub."
QueuedConnection = _unserved.class_of(_HERE + "QueuedConnection")
TCPROSHandler = _unserved.class_of(_HERE + "TCPROSHandler", ProtocolHandler)
TCPROSPub = _unserved.class_of(_HERE + "TCPROSPub", TCPROSTransportProtocol)
TCPROSSub = _unserved.class_of(_HERE + "TCPROSSub", TCPROSTransportProtocol)
check_if_still_publisher = _unserved.function(_HERE + "check_if_still_publisher")
robust_connect_subscriber = _unserved.function(_HERE + "robust_connect_subscriber")
