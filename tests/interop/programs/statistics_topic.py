# ruff: noqa: B007
"""/enable_statistics."""

import rospy
from geometry_msgs.msg import PointStamped
from rosgraph_msgs.msg import TopicStatistics
from std_msgs.msg import Header, String

rospy.init_node("st")
got = []
ss = rospy.Subscriber("/statistics", TopicStatistics, got.append)
s = rospy.Subscriber("x", PointStamped, lambda m: None)
p = rospy.Publisher("x", PointStamped, queue_size=10)
while not p.get_num_connections():
    rospy.sleep(0.05)
for i in range(28):
    p.publish(PointStamped(header=Header(stamp=rospy.Time.now())))
    rospy.sleep(0.1)
for m in got:
    if m.topic != "/x" or m.delivered_msgs < 5:  # the first report may come before the connection
        continue
    print(
        m.topic,
        m.node_pub,
        m.node_sub,
        m.delivered_msgs > 15,
        m.dropped_msgs,
        m.traffic == 44 * m.delivered_msgs,
        round(m.period_mean.to_sec(), 1),
        m.stamp_age_mean.to_sec() < 0.1,
        m.period_max.to_sec() < 0.2,
        round((m.window_stop - m.window_start).to_sec()),
        m.stamp_age_max >= m.stamp_age_mean,
    )
