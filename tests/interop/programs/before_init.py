"""Topics before init_node, init_node twice, odd node names."""

import rospy
from std_msgs.msg import String

got = []
p = rospy.Publisher("x", String, queue_size=1)
s = rospy.Subscriber("x", String, lambda m: got.append(m.data))
try:
    p.publish("early")
except Exception as e:
    print(type(e), e)
try:
    rospy.Publisher("~x", String, queue_size=1)
except Exception as e:
    print(type(e), e)
try:
    rospy.Subscriber("~x", String, print)
except Exception as e:
    print(type(e), e)
print(rospy.get_name(), rospy.get_namespace(), rospy.is_shutdown(), p.get_num_connections())
rospy.init_node("late")
print(
    rospy.get_name(),
    rospy.get_caller_id(),
    rospy.get_namespace(),
    rospy.get_node_uri().startswith("http://127"),
)
while not p.get_num_connections():
    rospy.sleep(0.05)
p.publish("now")
while not got:
    rospy.sleep(0.01)
print(got, s.get_num_connections())
for f in [
    lambda: rospy.init_node("late"),
    lambda: rospy.init_node("other"),
    lambda: rospy.init_node("late", anonymous=True),
    lambda: rospy.init_node("late", log_level=rospy.DEBUG),
    lambda: rospy.init_node("late", disable_signals=True),
]:
    try:
        print(f())
    except Exception as e:
        print(type(e).__name__, str(e).split("[")[0])
for n in ["", "a/b", "/x", None, 5]:
    try:
        rospy.init_node(n)
    except Exception as e:
        print(repr(n), type(e).__name__, str(e).split("[")[0])
