"""tf2_ros.StaticTransformBroadcaster."""

import rospy
from tf2_msgs.msg import TFMessage

from .transform_broadcaster import TransformBroadcaster


class StaticTransformBroadcaster(TransformBroadcaster):
    """Publishes /tf_static, latched: late subscribers receive the last message."""

    def __init__(self):
        self.pub_tf = rospy.Publisher("/tf_static", TFMessage, queue_size=100, latch=True)
