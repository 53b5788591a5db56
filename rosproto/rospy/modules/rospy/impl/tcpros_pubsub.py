"""rospy.impl.tcpros_pubsub: the names that programs import from it."""

from ._unserved import unserved
from .tcpros_base import TCPROSTransport, TCPROSTransportProtocol
from .transport import ProtocolHandler

_HERE = "rospy.impl.tcpros_pubsub."
QueuedConnection = unserved(_HERE + "QueuedConnection")
TCPROSHandler = unserved(_HERE + "TCPROSHandler", ProtocolHandler)
TCPROSPub = unserved(_HERE + "TCPROSPub", TCPROSTransportProtocol)
TCPROSSub = unserved(_HERE + "TCPROSSub", TCPROSTransportProtocol)
check_if_still_publisher = unserved(_HERE + "check_if_still_publisher")
robust_connect_subscriber = unserved(_HERE + "robust_connect_subscriber")
