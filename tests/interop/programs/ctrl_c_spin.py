"""Ctrl-C ends spin; a non-daemon thread of the program ends by is_shutdown."""

import threading
import time

import rospy

rospy.init_node("spinning")


def work():
    while not rospy.is_shutdown():
        time.sleep(0.02)
    time.sleep(0.8)
    print("thread over")


threading.Thread(target=work).start()
print("ready", flush=True)
rospy.spin()
print("spin over", rospy.is_shutdown())
