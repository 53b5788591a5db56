"""/enable_statistics."""

import rospy
from geometry_msgs.msg import PointStamped
from rosgraph_msgs.msg import TopicStatistics
from std_msgs.msg import Header, String

rospy.init_node("st")
got = []
ss = rospy.Subscriber("/statistics", TopicStatistics, got.append)
seen = []
s = rospy.Subscriber("x", PointStamped, seen.append)
p = rospy.Publisher("x", PointStamped, queue_size=10)
while not p.get_num_connections():
    rospy.sleep(0.05)


def reports():
    # The first may come before the connection.
    return [m for m in got if m.topic == "/x" and m.delivered_msgs >= 5]


while not reports():
    count = len(seen)
    p.publish(PointStamped(header=Header(stamp=rospy.Time.now())))
    while len(seen) == count:  # rospy counts the bytes of all that it reads at a time with the first
        rospy.sleep(0.005)
    rospy.sleep(0.05)
m = reports()[0]
print(
    m.topic,
    m.node_pub,
    m.node_sub,
    m.dropped_msgs,
    m.traffic == 44 * m.delivered_msgs,
    0.04 < m.period_mean.to_sec() <= m.period_max.to_sec(),
    0 <= m.stamp_age_mean.to_sec() <= m.stamp_age_max.to_sec(),
    m.window_start < m.window_stop,
)
