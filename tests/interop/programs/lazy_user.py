"""Listens to the relay twice, and waits each time until the relay has left its own source."""

import threading

import rospy
from std_msgs.msg import String

rospy.init_node("user")
source = rospy.Publisher("/in", String, queue_size=5)


def wait_for(holds):
    while not rospy.is_shutdown() and not holds():
        rospy.sleep(0.05)


def listen_once():
    print("before: %d" % source.get_num_connections())
    heard = threading.Event()
    sub = rospy.Subscriber("/out", String, lambda message: heard.set())
    wait_for(source.get_num_connections)

    def came():
        source.publish(data="hello")
        return heard.is_set()

    wait_for(came)
    sub.unregister()
    wait_for(lambda: not source.get_num_connections())
    print("heard, and the relay has left")


listen_once()
listen_once()
