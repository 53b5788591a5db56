"""Ctrl-C during a service call that takes long."""

import rospy
from std_srvs.srv import Trigger

rospy.init_node("calling")
rospy.wait_for_service("slow")
print("ready", flush=True)
try:
    rospy.ServiceProxy("slow", Trigger)()
except rospy.ROSInterruptException as e:
    print(type(e).__name__, e)
