"""headers= of Publisher, as a subscriber sees them."""

import rospy
from std_msgs.msg import String

rospy.init_node("hd")


got = []


def cb(m):
    h = m._connection_header
    print(sorted(h), h.get("pi"), h.get("n"), h["callerid"], h["latching"], h["topic"], h["type"])
    got.append(m)


s = rospy.Subscriber("x", String, cb)
p = rospy.Publisher("x", String, headers={"pi": "3.14", "n": "5"}, queue_size=1, latch=True)
p.publish("a")
while not got:
    rospy.sleep(0.01)
print(rospy.get_node_uri().split(":")[1])
