"""Subscribe listeners, AnyMsg, latches, unregistering, header.seq."""

import rospy
from geometry_msgs.msg import PointStamped
from std_msgs.msg import Header, Int32, String

rospy.init_node("k2")


class L(rospy.SubscribeListener):
    def peer_subscribe(self, t, tp, pp):
        print("sub", t)
        pp(String("welcome"))
        came.append(t)  # now its buffer is free for the next publish()

    def peer_unsubscribe(self, t, n):
        print("unsub", t, n)
        gone.append(t)


came, gone = [], []
p = rospy.Publisher("w", String, subscriber_listener=L(), queue_size=5)
got = []
s = rospy.Subscriber("w", String, lambda m: got.append(m.data))
while not (got and came):
    rospy.sleep(0.01)
p.publish("x")
while len(got) < 2:
    rospy.sleep(0.01)
s.unregister()
while not gone:
    rospy.sleep(0.01)
print(got, p.get_num_connections())
a = []
sa = rospy.Subscriber(
    "/pt", rospy.AnyMsg, lambda m: a.append((m._connection_header["type"], len(m._buff), m._type))
)
pp = rospy.Publisher("/pt", PointStamped, queue_size=5)
while not pp.get_num_connections():
    rospy.sleep(0.05)
pp.publish(PointStamped(header=Header(seq=9, frame_id="f")))
while not a:
    rospy.sleep(0.01)
print(a)
n = []


def once(m):
    n.append(m.data)
    so.unregister()


so = rospy.Subscriber("o", Int32, once)
po = rospy.Publisher("o", Int32, queue_size=5)
while not po.get_num_connections():
    rospy.sleep(0.05)
po.publish(0)
while po.get_num_connections():
    rospy.sleep(0.01)
po.publish(1)
print(n, po.get_num_connections())
lp = rospy.Publisher("lat", String, latch=True, queue_size=1)
lp.publish("first")
lp.publish("second")
r = []
s1 = rospy.Subscriber("lat", String, lambda m: r.append(("a", m.data)))
while not r:
    rospy.sleep(0.01)
s2 = rospy.Subscriber("lat", String, lambda m: r.append(("b", m.data)))
while len(r) < 2:
    rospy.sleep(0.01)
print(r)
print(rospy.wait_for_message("lat", String, timeout=2).data)
try:
    rospy.wait_for_message("none", String, timeout=0.2)
except rospy.ROSException as e:
    print(e)
try:
    rospy.wait_for_message("none", String, timeout=rospy.Duration(0.2))
except rospy.ROSException as e:
    print(e)
try:
    rospy.wait_for_message("lat", "x", timeout=0.2)
except Exception as e:
    print(type(e).__name__, e)
h = PointStamped()
pp.publish(h)
print(h.header.seq, h.header.stamp, h.header.frame_id == "")
pp.publish(h)
print(h.header.seq)
h.header.frame_id = None
pp.publish(h)
print(repr(h.header.frame_id))
p1 = rospy.Publisher("same", String, queue_size=1)
p2 = rospy.Publisher("same", String, queue_size=1)
p1.unregister()
p2.publish("ok")
print(p2.get_num_connections())
topics = rospy.topics.get_topic_manager()
print("/same" in topics.get_topics(), topics.has_publication("/same"), topics.has_subscription("/same"))
