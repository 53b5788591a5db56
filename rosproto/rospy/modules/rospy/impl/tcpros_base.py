"""rospy.impl.tcpros_base: the names that programs import from it."""

from ._unserved import unserved
from .transport import BIDIRECTIONAL, Transport

DEFAULT_BUFF_SIZE = 65536
TCPROS = "TCPROS"

_HERE = "rospy.impl.tcpros_base."
TCPROSServer = unserved(_HERE + "TCPROSServer")
TCPROSTransport = unserved(_HERE + "TCPROSTransport", Transport)
init_tcpros_server = unserved(_HERE + "init_tcpros_server")
start_tcpros_server = unserved(_HERE + "start_tcpros_server")


class TCPROSTransportProtocol:
    """One end of a connection; for derived classes."""

    def __init__(self, resolved_name, recv_data_class, queue_size=None, buff_size=65536):
        if recv_data_class and not hasattr(recv_data_class, "_md5sum"):
            raise ValueError("recv_data_class must be a message class")
        self.resolved_name, self.recv_data_class = resolved_name, recv_data_class
        self.queue_size, self.buff_size = queue_size, buff_size
        self.direction = BIDIRECTIONAL

    def get_header_fields(self):
        """The fields of its connection header."""
        return {}


def get_tcpros_server_address():
    """(host, port) where subscribers and clients of services connect; None before there is a node."""
    from . import init

    return None if init.node is None else init.node.tcpros_address
