"""message_filters: exact and approximate synchronizers, a cache, several sources, late messages."""

import message_filters
import rospy
from sensor_msgs.msg import CameraInfo, Image, Imu

rospy.init_node("stereo_sync")
topics = {"left": Image, "right": Image, "info": CameraInfo, "imu": Imu}
subs = {name: message_filters.Subscriber(name, kind, queue_size=20) for name, kind in topics.items()}
pubs = {name: rospy.Publisher(name, kind, queue_size=20) for name, kind in topics.items()}
exact, near, three = [], [], []
message_filters.TimeSynchronizer([subs["left"], subs["right"]], 10).registerCallback(
    lambda a, b, tag: exact.append((a.header.stamp.to_sec(), b.header.stamp.to_sec(), tag)), "tag"
)
ats = message_filters.ApproximateTimeSynchronizer([subs["left"], subs["imu"]], 10, 0.05)
ats.registerCallback(lambda a, b: near.append((a.header.stamp.to_sec(), b.header.stamp.to_sec())))
message_filters.TimeSynchronizer([subs["left"], subs["right"], subs["info"]], queue_size=3).registerCallback(
    lambda *m: three.append([type(x).__name__ for x in m])
)
cache = message_filters.Cache(subs["imu"], 5)
through = []
for name, kind in topics.items():
    rospy.Subscriber(name, kind, through.append)  # the last that is called
while not all(p.get_num_connections() for p in pubs.values()):
    rospy.sleep(0.02)


def send(name, seconds):
    message = topics[name]()
    message.header.stamp = rospy.Time.from_sec(seconds)
    count = len(through)
    pubs[name].publish(message)
    while len(through) == count:
        rospy.sleep(0.005)


for i in range(8):
    t = 10 + i * 0.1
    send("imu", t + (0.02 if i % 2 else 0.2))
    send("left", t)
    if i != 3:
        send("right", t)
    if i in (2, 3, 5):
        send("info", t)
send("right", 10.3)
print([(round(a, 3), round(b, 3), tag) for a, b, tag in exact])
print([(round(a, 3), round(b, 3)) for a, b in near])
print(three)
print([round(m.header.stamp.to_sec(), 2) for m in cache.getInterval(rospy.Time(10.3), rospy.Time(10.7))])
print(cache.getLastestTime().to_sec(), cache.getOldestTime().to_sec(), cache.getElemBeforeTime(rospy.Time(1)))
print(
    cache.getElemAfterTime(rospy.Time.from_sec(10.55)).header.stamp.to_sec(),
    cache.getLast().header.stamp.to_sec(),
)
