# ruff: noqa: B007
"""Persistent proxies; headers= of ServiceProxy, as the handler sees them."""

import rospy
from std_srvs.srv import Empty, Trigger, TriggerResponse

rospy.init_node("pers")
n = [0]


def h(req):
    n[0] += 1
    if n[0] == 3:
        raise ValueError("third")
    hdr = req._connection_header
    return TriggerResponse(True, "%d %s %s" % (n[0], hdr.get("persistent"), hdr["callerid"]))


s = rospy.Service("t", Trigger, h)
p = rospy.ServiceProxy("t", Trigger, persistent=True)
for i in range(5):
    try:
        print(p().message)
    except rospy.ServiceException as e:
        print("E", e)
print("c")
try:
    print(p().message)
except rospy.ServiceException as e:
    print("E", e)
p2 = rospy.ServiceProxy("t", Trigger, True, headers={"cookie": "abc", "n": "5"})


def h2(req):
    hdr = req._connection_header
    return TriggerResponse(True, "%s %s" % (hdr.get("cookie"), sorted(set(hdr) - {"type"})))


s.shutdown()
s = rospy.Service("t", Trigger, h2)
try:
    print(p2().message)
except rospy.ServiceException as e:
    print("E", e)
p3 = rospy.ServiceProxy("t", Trigger, headers={"cookie": "xyz"})
print(p3().message)
