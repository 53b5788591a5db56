"""A node under the name that its argument gives, with topics, a parameter and a service below that name."""

import sys
import time

import rosgraph
import rospy
from roscpp.srv import Empty, EmptyResponse
from std_msgs.msg import String

try:
    rospy.init_node(sys.argv[1])
except ValueError as error:
    print(error)
    raise SystemExit(3) from None
print(repr(rospy.get_name()), repr(rospy.get_namespace()))
heard = []
publisher = rospy.Publisher("~chat", String, queue_size=1, latch=True)
publisher.publish("x")
rospy.Subscriber("~chat", String, lambda m: heard.append(m._connection_header["callerid"]))
rospy.Service("~service", Empty, lambda request: EmptyResponse())
end = time.time() + 10
while not heard and time.time() < end:
    rospy.sleep(0.01)
print(heard)
rospy.set_param("~value", 1)
print(rospy.get_param("~value"), repr(rospy.ServiceProxy("~service", Empty)()))
for wrong in ("not:a:name", "two words"):
    try:
        rospy.ServiceProxy(wrong, Empty)()
    except rospy.ServiceException as error:
        print(error)
table = rosgraph.Master("/x").getSystemState()
print([sorted(name for name, nodes in rows if "logger" not in name) for rows in table])
