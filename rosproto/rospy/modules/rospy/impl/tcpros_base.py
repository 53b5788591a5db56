"""rospy.impl.tcpros_base: the names that programs import from it."""

from . import _unserved
from ._unserved import TCPROSTransport, TCPROSTransportProtocol

__all__ = [
    "DEFAULT_BUFF_SIZE",
    "TCPROS",
    "TCPROSServer",
    "TCPROSTransport",
    "TCPROSTransportProtocol",
    "get_tcpros_server_address",
    "init_tcpros_server",
    "start_tcpros_server",
]

DEFAULT_BUFF_SIZE = 65536
TCPROS = "TCPROS"

TCPROSServer = _unserved.class_of("rospy.impl.tcpros_base.TCPROSServer")
init_tcpros_server = _unserved.function("rospy.impl.tcpros_base.init_tcpros_server")
start_tcpros_server = _unserved.function("rospy.impl.tcpros_base.start_tcpros_server")


def get_tcpros_server_address():
    """(host, port) where subscribers and clients of services connect; None before there is a node."""
    from . import init

    return None if init.node is None else init.node.tcpros_address
