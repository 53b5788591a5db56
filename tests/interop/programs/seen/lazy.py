# ruff: noqa: B023
"""A lazy node: subscribes to its source only while somebody listens to it, by SubscribeListener and counts."""

import threading

import rospy
from std_msgs.msg import Int32

rospy.init_node("lazy")
events, lock = [], threading.RLock()


class Listener(rospy.SubscribeListener):
    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        with lock:
            peer_publish(
                Int32(-1)
            )  # in rospy by the buffer of publish(), so nothing is published before it returns
            events.append("subscribe %s" % topic_name.split("/")[-1])

    def peer_unsubscribe(self, topic_name, num_peers):
        with lock:
            events.append("unsubscribe %d" % num_peers)


class Lazy:
    def __init__(self):
        self.sub = None
        self.pub = rospy.Publisher("doubled", Int32, subscriber_listener=Listener(), queue_size=10)
        self.timer = rospy.Timer(rospy.Duration(0.02), self.check)

    def check(self, _):
        wanted = self.pub.get_num_connections() > 0
        if wanted and self.sub is None:
            self.sub = rospy.Subscriber("source", Int32, lambda m: self.pub.publish(m.data * 2))
        elif not wanted and self.sub is not None:
            self.sub.unregister()
            self.sub = None


lazy = Lazy()
source = rospy.Publisher("source", Int32, queue_size=10)
for round_ in range(2):
    got = []
    ear = rospy.Subscriber("doubled", Int32, lambda m: got.append(m.data))
    while not source.get_num_connections():
        rospy.sleep(0.02)
    for i in range(4):  # the welcome first, then one by one
        while len(got) <= i or len(events) <= 2 * round_:
            rospy.sleep(0.01)
        if i < 3:
            source.publish(i)
    ear.unregister()
    while source.get_num_connections() or len(events) < 2 * round_ + 2:
        rospy.sleep(0.02)
    print(round_, got)
while len(events) < 4 or lazy.sub is not None:
    rospy.sleep(0.01)
print(events, lazy.sub)
