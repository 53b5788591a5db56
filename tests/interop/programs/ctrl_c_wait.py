"""Ctrl-C while waiting for a service."""

import rospy

rospy.init_node("waiting")
print("ready", flush=True)
try:
    rospy.wait_for_service("never")
except rospy.ROSInterruptException as e:
    print(type(e).__name__, e)
rospy.wait_for_service("never")
