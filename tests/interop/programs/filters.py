"""message_filters: exact, approximate, cached."""

import message_filters
import rospy
from geometry_msgs.msg import PointStamped
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import Header, Int32

rospy.init_node("mf")
a = message_filters.Subscriber("a", PointStamped)
b = message_filters.Subscriber("b", PointStamped, queue_size=5)
pa, pb = (
    rospy.Publisher("a", PointStamped, queue_size=100),
    rospy.Publisher("b", PointStamped, queue_size=100),
)
ts = message_filters.TimeSynchronizer([a, b], 10)
ts.registerCallback(lambda x, y: print("exact", x.header.stamp, y.header.stamp))


def cb(x, y, extra):
    print("approx", x.header.stamp.to_sec(), y.header.stamp.to_sec(), extra)


ap = message_filters.ApproximateTimeSynchronizer([a, b], 10, 0.1)
ap.registerCallback(cb, "E")
ca = message_filters.Cache(a, 3)
through = []
for name in ("a", "b"):
    rospy.Subscriber(name, PointStamped, through.append)  # the last that is called
while not (pa.get_num_connections() and pb.get_num_connections()):
    rospy.sleep(0.05)


def m(t):
    return PointStamped(header=Header(stamp=rospy.Time(t)))


def send(publisher, message):
    """Publish, and wait until all callbacks have been called: topics have a thread each."""
    count = len(through)
    publisher.publish(message)
    while len(through) == count:
        rospy.sleep(0.005)


for i in range(6):
    send(pa, m(10 + i))
    send(pb, m(10 + i + (0.05 if i % 2 else 0.0)))
send(pb, m(30.05))
send(pb, m(30.02))
send(pa, m(30.03))
print(
    [x.header.stamp.secs for x in ca.getInterval(rospy.Time(0), rospy.Time(100))],
    ca.getElemBeforeTime(rospy.Time(14.5)).header.stamp,
    ca.getElemAfterTime(rospy.Time(14.5)).header.stamp,
    ca.getLastestTime() if hasattr(ca, "getLastestTime") else ca.getLatestTime(),
    ca.getOldestTime(),
    ca.getLast().header.stamp,
)
h = message_filters.Subscriber("h", Int32)
hh = message_filters.Subscriber("h2", Int32)
ph, ph2 = rospy.Publisher("h", Int32, queue_size=10), rospy.Publisher("h2", Int32, queue_size=10)
no = message_filters.ApproximateTimeSynchronizer([h, hh], 5, 0.5)
no.registerCallback(lambda x, y: print("never"))
al = message_filters.ApproximateTimeSynchronizer([h, hh], 5, 20, allow_headerless=True)
al.registerCallback(lambda x, y: print("headerless", x.data, y.data))
try:
    c2 = message_filters.Cache(h, 5)
except Exception as e:
    print(type(e), e)
for name in ("h", "h2"):
    rospy.Subscriber(name, Int32, through.append)
while not (ph.get_num_connections() and ph2.get_num_connections()):
    rospy.sleep(0.05)
for i in range(2):
    send(ph, Int32(i))
    send(ph2, Int32(i))


class F(message_filters.SimpleFilter):
    pass


f = F()
f.registerCallback(print, "x", "y")
f.signalMessage("m")
print(a.topic if hasattr(a, "topic") else "", a.getTopic() if hasattr(a, "getTopic") else "")
ch = message_filters.Cache(h, 5, allow_headerless=True)
