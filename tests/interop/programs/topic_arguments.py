"""Arguments of Publisher and Subscriber, right and wrong, and their attributes."""

import warnings

import rospy
from std_msgs.msg import Int8, String


def t(f):
    try:
        r = f()
        print(type(r).__name__)
    except Exception as e:
        print(type(e).__module__, type(e).__name__, e)


t(lambda: rospy.Publisher("a", String))
rospy.init_node("p")
t(lambda: rospy.Publisher("a", String))
t(lambda: rospy.Publisher("b", String, queue_size=None))
t(lambda: rospy.Publisher("c", String, queue_size=0))
t(lambda: rospy.Publisher("d", String, queue_size=-1))
t(lambda: rospy.Publisher("d2", String, queue_size="5"))
t(lambda: rospy.Publisher("e", "std_msgs/String", queue_size=1))
t(lambda: rospy.Publisher("e", None, queue_size=1))
t(lambda: rospy.Publisher("", String, queue_size=1))
t(lambda: rospy.Publisher(None, String, queue_size=1))
t(lambda: rospy.Publisher(5, String, queue_size=1))
t(lambda: rospy.Publisher("f", object, queue_size=1))
t(lambda: rospy.Publisher("f", String(), queue_size=1))
t(lambda: rospy.Publisher("g", String, lambda x: 1, queue_size=1))
t(lambda: rospy.Publisher("g2", String, 10))
t(lambda: rospy.Publisher("h", String, headers={"a": "b"}, queue_size=1))
t(lambda: rospy.Publisher("h2", String, headers={"a": 5}, queue_size=1))
t(lambda: rospy.Publisher("h3", String, headers=5, queue_size=1))
t(lambda: rospy.Subscriber("a", String))
t(lambda: rospy.Subscriber("a", String, 5))
t(lambda: rospy.Subscriber("a", String, print, queue_size=0))
t(lambda: rospy.Subscriber("a2", String, print, queue_size=-1))
t(lambda: rospy.Subscriber("a3", String, print, queue_size="1"))
t(lambda: rospy.Subscriber("a4", String, print, buff_size=0))
t(lambda: rospy.Subscriber("a5", String, print, buff_size="1"))
t(lambda: rospy.Subscriber("a6", String, print, buff_size=2**24, tcp_nodelay=True))
t(lambda: rospy.Subscriber("a", Int8, print))
t(lambda: rospy.Publisher("a", Int8, queue_size=1))
t(lambda: rospy.Subscriber("e", "std_msgs/String", print))
t(lambda: rospy.Subscriber("", String, print))
t(lambda: rospy.Subscriber())
t(lambda: rospy.Publisher())
t(lambda: rospy.Subscriber("z", String, print, bad=1))
p = rospy.Publisher("q", String, queue_size=3, latch=True)
print(
    p.name,
    p.resolved_name,
    p.type,
    p.md5sum == String._md5sum,
    p.data_class is String,
    p.reg_type,
    p.get_num_connections(),
    p.impl.is_latch,
    p.impl.queue_size,
)
s = rospy.Subscriber("~q", String, print, callback_args=1)
print(s.name, s.resolved_name, s.type, s.callback is print, s.callback_args, s.reg_type)
p.unregister()
print(p.name, p.resolved_name, p.type)
try:
    p.publish("x")
except Exception as e:
    print(type(e), e)
try:
    print(p.get_num_connections())
except Exception as e:
    print(type(e), e)
s.unregister()
s.unregister()
p.unregister()
print(s.callback, s.name)
