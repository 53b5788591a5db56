"""Latched topics, both ways, and callbacks added later."""

import rospy
from std_msgs.msg import Int8, String

rospy.init_node("latched")
got = []
rospy.Subscriber("given", String, lambda m: got.append(("one", m.data)))
end = rospy.Time.now() + rospy.Duration(5)
while not got and rospy.Time.now() < end:
    rospy.sleep(0.05)
rospy.Subscriber("given", String, lambda m, extra: got.append((extra, m.data)), callback_args="two")
rospy.sleep(0.2)
print(got)
print(rospy.wait_for_message("given", String, timeout=3).data)
mine = rospy.Publisher("mine", Int8, latch=True, queue_size=1)
mine.publish(5)
mine.publish(6)
print(rospy.wait_for_message("mine", Int8, timeout=3).data)
rospy.sleep(0.5)
