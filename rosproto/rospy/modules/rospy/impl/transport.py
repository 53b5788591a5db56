"""rospy.impl.transport: rospy's connection classes, for programs that import them or derive from them.

The node's connections are not instances of these classes.
"""

import itertools

INBOUND = "i"
OUTBOUND = "o"
BIDIRECTIONAL = "b"

_ids = itertools.count(1)


class Transport:
    """A connection with rospy's counters."""

    transport_type = "UNKNOWN"

    def __init__(self, direction, name="unnamed"):
        self.name, self.direction = name, direction
        self.done = False
        self.cleanup_cb = None
        self.endpoint_id = ""
        self.id = next(_ids)
        self.stat_bytes = self.stat_num_msg = 0
        self.local_endpoint = self.remote_endpoint = (0, 0)

    def fileno(self):
        """Descriptor for select(); None when there is none."""

    def set_cleanup_callback(self, cleanup_callback):
        """Have `cleanup_callback(transport)` called when it is closed."""
        self.cleanup_cb = cleanup_callback

    def close(self):
        """Close it."""
        self.done = True
        if self.cleanup_cb:
            self.cleanup_cb(self)

    def write_data(self, data):
        """Send bytes; for derived classes."""
        raise Exception("not implemented")

    def get_transport_info(self):
        """Its entry in getBusInfo; for derived classes."""
        raise NotImplementedError


class DeadTransport(Transport):
    """The counters of a closed connection."""

    def __init__(self, transport):
        super().__init__(transport.direction, transport.name)
        kept = vars(transport) | {"transport_type": transport.transport_type}
        vars(self).update(kept, cleanup_cb=None, done=True)

    def get_transport_info(self):
        """The peer it was connected to."""
        kind, (_, port), (host, other) = self.transport_type, self.local_endpoint, self.remote_endpoint
        return "Closed %s connection on port %s to [%s:%s]" % (kind, port, host, other)


class ProtocolHandler:
    """The interface of a transport protocol; for derived classes."""

    def shutdown(self):
        """Close it."""

    def create_transport(self, topic, pub_uri, protocol_params):
        """Connect to a publisher."""
        raise Exception("interface impl")

    def supports(self, protocol):
        """True for a protocol that it speaks."""
        return False

    def get_supported(self):
        """What a subscriber offers."""
        return []

    def init_publisher(self, topic, protocol):
        """Answer a subscriber's offer."""
        raise Exception("interface impl")
