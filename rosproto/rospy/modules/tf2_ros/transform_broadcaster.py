"""tf2_ros.TransformBroadcaster."""

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage


class TransformBroadcaster:
    """Publishes /tf."""

    def __init__(self):
        self.pub_tf = rospy.Publisher("/tf", TFMessage, queue_size=100)

    def sendTransform(self, transform):
        """Send a TransformStamped, or a list of them."""
        self.pub_tf.publish(TFMessage(transform if isinstance(transform, list) else [transform]))
