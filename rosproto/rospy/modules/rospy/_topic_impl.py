"""Base of published and subscribed topics; the Publisher or Subscriber objects of a topic share one."""

import sys
import threading
import time

SETTLE = 0.02
"""Seconds after the registration in which no callback comes: rospy's links take longer, and programs use what
`self.sub = rospy.Subscriber(...)` assigns in the callback."""
MOST_ATTACHING = 1.0  # seconds
UNBOUNDED = sys.maxsize  # messages that may wait; rospy has no bound by default


class Connection:
    """A peer, with the attributes that programs use.

    Attributes:
        endpoint_id: Its node name for a subscriber of ours, its URI for a publisher.
        callerid_pub: Its node name.
    """

    def __init__(self, endpoint_id, callerid):
        self.endpoint_id = endpoint_id
        self.callerid_pub = self.callerid = callerid
        self.done = False


class TopicImpl:
    """One topic of this process, in one direction.

    Attributes:
        handle: The node's Publisher or Subscriber; None before there is a node.
        refused: The master did not take the registration; nothing is sent or received.
    """

    def __init__(self, name, data_class):
        self.resolved_name = self.name = name
        self.data_class = data_class
        self.type = data_class._type
        self.ref_count = 0
        self.closed = self.refused = False
        self.handle = None
        self.c_lock = threading.RLock()
        self._settled = False
        self._attached = threading.Event()
        self._settles_at = 0.0

    def attached(self):
        """Note that the node has the topic; the program goes on behind the constructor."""
        self._settles_at = time.monotonic() + SETTLE
        self._attached.set()

    def settle(self):
        """Called before the first callback, in a thread of the library: give the program time to go on."""
        if self._attached.wait(MOST_ATTACHING):
            time.sleep(max(0.0, self._settles_at - time.monotonic()))
        self._settled = True

    @property
    def connections(self):
        """The peers connected now."""
        return []

    def get_num_connections(self):
        """The number of peers connected now."""
        return 0 if self.handle is None or self.closed else self.handle.connections

    def has_connection(self, endpoint_id):
        """True when this peer is connected."""
        return any(connection.endpoint_id == endpoint_id for connection in self.connections)

    def has_connections(self):
        """True when any peer is connected."""
        return self.get_num_connections() > 0

    def close(self):
        """Close the topic."""
        self.closed = True
        if self.handle is not None:
            self.handle.close()
