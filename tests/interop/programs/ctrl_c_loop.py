"""Ctrl-C ends a loop over is_shutdown, with hooks before."""

import rospy

rospy.init_node("loop")
rospy.on_shutdown(lambda: print("hook", rospy.is_shutdown()))
rate = rospy.Rate(10)
print("ready", flush=True)
while not rospy.is_shutdown():
    rate.sleep()
print("end of loop")
