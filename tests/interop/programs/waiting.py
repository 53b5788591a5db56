"""wait_for_message: there, not there, as Duration."""

import rospy
from std_msgs.msg import String

rospy.init_node("waiting")
print(rospy.wait_for_message("given", String).data)
print(rospy.wait_for_message("given", String, timeout=5.0)._connection_header["type"])
for timeout in (0.3, rospy.Duration(0.3)):
    try:
        rospy.wait_for_message("silent", String, timeout=timeout)
    except rospy.ROSException as e:
        print(type(e).__name__, e)
rospy.wait_for_message("silent2", String, 0.2)
