"""tf2_ros.StaticTransformBroadcaster."""

import rospy
from tf2_msgs.msg import TFMessage


class StaticTransformBroadcaster:
    """Publishes /tf_static, latched: late subscribers receive the last message."""

    def __init__(self):
        self.pub_tf = rospy.Publisher("/tf_static", TFMessage, queue_size=100, latch=True)

    def sendTransform(self, transform):
        """Send a TransformStamped, or a list of them."""
        self.pub_tf.publish(TFMessage(transform if isinstance(transform, list) else [transform]))
