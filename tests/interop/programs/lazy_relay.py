"""A relay by topic_tools.LazyTransport, until it has unsubscribed twice."""

import threading

import rospy
from std_msgs.msg import String
from topic_tools import LazyTransport

done = threading.Event()
told = []


class Relay(LazyTransport):
    def __init__(self):
        super(Relay, self).__init__()
        for wrong in (LazyTransport.subscribe, LazyTransport.unsubscribe):
            try:
                wrong(self)
            except NotImplementedError:
                told.append("to be overridden")
        self.pub = self.advertise("/out", String, queue_size=5)

    def subscribe(self):
        told.append("subscribe")
        self.sub = rospy.Subscriber("/in", String, self.pub.publish)

    def unsubscribe(self):
        told.append("unsubscribe")
        self.sub.unregister()
        if told.count("unsubscribe") == 2:
            done.set()


rospy.init_node("relay")
relay = Relay()
done.wait(40)
print(told)
