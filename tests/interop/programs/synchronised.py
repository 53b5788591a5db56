"""message_filters: exact and approximate synchronisers, cache."""

import message_filters
import rospy
from sensor_msgs.msg import LaserScan

rospy.init_node("synchronised")
a, b = message_filters.Subscriber("a", LaserScan), message_filters.Subscriber("b", LaserScan)
exact, near = [], []
message_filters.TimeSynchronizer([a, b], 10).registerCallback(
    lambda x, y: exact.append((x.header.stamp.secs, y.header.stamp.secs))
)
message_filters.ApproximateTimeSynchronizer([a, b], 10, 0.5).registerCallback(
    lambda x, y: near.append((x.header.stamp.to_sec(), y.header.stamp.to_sec()))
)
cache = message_filters.Cache(a, 3)
through = []
for name in "ab":
    rospy.Subscriber(name, LaserScan, through.append)  # the last that is called
pubs = [rospy.Publisher(name, LaserScan, queue_size=20) for name in "ab"]
while not all(p.get_num_connections() for p in pubs):
    rospy.sleep(0.05)
for name, stamp in ((0, 1.0), (1, 1.0), (0, 2.0), (1, 2.25), (0, 3.0), (1, 4.0), (0, 4.125)):
    message = LaserScan()
    message.header.stamp = rospy.Time.from_sec(stamp)
    count = len(through)
    pubs[name].publish(message)
    while len(through) == count:
        rospy.sleep(0.005)
print(exact, near)
print(cache.getLastestTime(), cache.getOldestTime(), cache.getElemBeforeTime(rospy.Time(3)).header.stamp)
print([m.header.stamp.to_sec() for m in cache.getInterval(rospy.Time(2), rospy.Time(5))])
