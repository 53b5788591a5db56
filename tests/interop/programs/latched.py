"""Latched topics, both ways, and callbacks added later."""

import rospy
from std_msgs.msg import Int8, String

rospy.init_node("latched")
got = []
rospy.Subscriber("given", String, lambda m: got.append(("one", m.data)))
while not got:
    rospy.sleep(0.01)
rospy.Subscriber("given", String, lambda m, extra: got.append((extra, m.data)), callback_args="two")
while len(got) < 2:
    rospy.sleep(0.01)
print(got)
print(rospy.wait_for_message("given", String, timeout=20).data)
mine = rospy.Publisher("mine", Int8, latch=True, queue_size=2)
while not mine.get_num_connections():  # the peer hears both, or the last only: as it comes earlier or later
    rospy.sleep(0.01)
mine.publish(5)
mine.publish(6)
print(rospy.wait_for_message("mine", Int8, timeout=20).data)
while rospy.get_param("/heard/ear", 0) < 2:
    rospy.sleep(0.01)
