"""Ctrl-C ends spin; a non-daemon thread of the program ends by is_shutdown."""

import threading
import time

import rospy

rospy.init_node("spinning")
spun = threading.Event()


def work():
    while not rospy.is_shutdown():
        time.sleep(0.02)
    spun.wait(60)  # two threads that print at their own pace have no order
    time.sleep(0.8)
    print("thread over")


threading.Thread(target=work).start()
print("ready", flush=True)
rospy.spin()
print("spin over", rospy.is_shutdown())
spun.set()
