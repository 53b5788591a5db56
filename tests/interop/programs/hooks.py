"""Shutdown hooks: their order, what they may do, what raises afterwards."""

import rospy
from std_msgs.msg import Float64

rospy.init_node("hooks")
pub = rospy.Publisher("stop", Float64, queue_size=10)
print(rospy.core.is_initialized(), rospy.is_shutdown())


def first():
    print("first", rospy.is_shutdown())
    pub.publish(0.0)
    while rospy.get_param("/heard/ear", 0) < 2:
        rospy.sleep(0.02)


def broken():
    raise ValueError("in a hook")


rospy.on_shutdown(first)
rospy.on_shutdown(broken)
rospy.on_shutdown(lambda: print("third"))
try:
    rospy.on_shutdown(5)
except TypeError as e:
    print(str(e).split(":")[0])
while pub.get_num_connections() == 0:
    rospy.sleep(0.05)
pub.publish(1.5)
rospy.signal_shutdown("done")
print("after", rospy.is_shutdown())
pub.publish(2.0)
for call in (lambda: rospy.wait_for_message("x", Float64), lambda: rospy.wait_for_service("x")):
    try:
        call()
    except rospy.ROSInterruptException as e:
        print(e, isinstance(e, KeyboardInterrupt))
