"""tf.TransformBroadcaster."""

import tf2_ros
from geometry_msgs.msg import TransformStamped


class TransformBroadcaster:
    """Publishes /tf; `queue_size` is ignored, tf2's applies."""

    def __init__(self, queue_size=100):
        self.tf2_broadcaster = tf2_ros.TransformBroadcaster()

    def sendTransform(self, translation, rotation, time, child, parent):
        """Publish the pose of `child` in `parent`: translation (x, y, z) in m, rotation (x, y, z, w)."""
        message = TransformStamped()
        message.header.frame_id, message.header.stamp, message.child_frame_id = parent, time, child
        t, r = message.transform.translation, message.transform.rotation
        t.x, t.y, t.z = translation[0], translation[1], translation[2]
        r.x, r.y, r.z, r.w = rotation[0], rotation[1], rotation[2], rotation[3]
        self.sendTransformMessage(message)

    def sendTransformMessage(self, transform):
        """Publish a TransformStamped."""
        self.tf2_broadcaster.sendTransform([transform])
