"""Stand-ins for rospy's internals that programs import and that have no counterpart here."""

from .transport import BIDIRECTIONAL, Transport


class Unserved(NotImplementedError):
    """A part of rospy was used that this layer does not have."""

    def __init__(self, name):
        super().__init__(
            "%s is a part of rospy's own connections, which are rosproto's here: use rospy.Publisher,"
            " Subscriber, Service and ServiceProxy, or for more rosproto.Node" % name
        )


def function(name):
    """A function that can be imported, and raises when it is called."""

    def unserved(*args, **kwds):
        raise Unserved(name)

    unserved.__name__ = unserved.__qualname__ = name.rpartition(".")[2]
    return unserved


def class_of(name, base=object):
    """A class that can be imported, derived from and used with isinstance; creating an instance raises."""

    def __init__(self, *args, **kwds):
        raise Unserved(name)

    return type(
        name.rpartition(".")[2], (base,), {"__init__": __init__, "__module__": name.rpartition(".")[0]}
    )


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


TCPROSTransport = class_of("rospy.impl.tcpros_base.TCPROSTransport", Transport)
