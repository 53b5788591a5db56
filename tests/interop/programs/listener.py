"""The tutorial's listener, ended by signal_shutdown from a callback."""

import rospy
from std_msgs.msg import String

seen = []


def callback(data):
    rospy.loginfo("%s I heard %s", rospy.get_caller_id(), data.data)
    seen.append(data.data)
    if len(seen) == 3:
        rospy.signal_shutdown("enough")


rospy.init_node("listener")
rospy.Subscriber("chatter", String, callback)
rospy.spin()
print(seen, rospy.is_shutdown())
