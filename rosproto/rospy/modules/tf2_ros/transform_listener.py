"""tf2_ros.TransformListener."""

import threading

import rospy
from tf2_msgs.msg import TFMessage


class TransformListener:
    """Fill a buffer from /tf and /tf_static."""

    def __init__(self, buffer, queue_size=None, buff_size=65536, tcp_nodelay=False):
        self.buffer = buffer
        self.last_update = rospy.Time.now()
        self.last_update_lock = threading.Lock()
        options = {"queue_size": queue_size, "buff_size": buff_size, "tcp_nodelay": tcp_nodelay}
        self.tf_sub = rospy.Subscriber("/tf", TFMessage, self.callback, **options)
        self.tf_static_sub = rospy.Subscriber("/tf_static", TFMessage, self.static_callback, **options)

    def __del__(self):
        self.unregister()

    def unregister(self):
        """Unsubscribe."""
        for part in ("tf_sub", "tf_static_sub"):
            if getattr(self, part, None) is not None:
                getattr(self, part).unregister()

    def check_for_reset(self):
        """Clear the buffer when the clock has jumped back."""
        with self.last_update_lock:  # around the reading, too: each topic and publisher has a thread
            now = rospy.Time.now()
            if now < self.last_update:
                rospy.logwarn(
                    "Detected jump back in time of %fs. Clearing TF buffer.",
                    (self.last_update - now).to_sec(),
                )
                self.buffer.clear()
            self.last_update = now

    def callback(self, data):
        """Store the transforms of a /tf message."""
        self.check_for_reset()
        self._take(data, self.buffer.set_transform)

    def static_callback(self, data):
        """Store the transforms of a /tf_static message."""
        self.check_for_reset()
        self._take(data, self.buffer.set_transform_static)

    @staticmethod
    def _take(data, take):
        who = data._connection_header.get("callerid", "default_authority")
        for transform in data.transforms:
            take(transform, who)
