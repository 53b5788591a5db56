"""Names: remapped on the command line, in a namespace, anonymous."""

import sys

import rospy
from std_msgs.msg import String

print(sys.argv[1:], rospy.get_name(), rospy.get_namespace())
pub = rospy.Publisher("chatter", String, queue_size=1, latch=True)
rospy.init_node("names", anonymous="--anonymous" in sys.argv)
print(rospy.get_name(), rospy.get_namespace(), rospy.get_caller_id())
print(
    pub.name, pub.resolved_name, rospy.resolve_name("x"), rospy.resolve_name("~x"), rospy.resolve_name("/x")
)
print(rospy.remap_name("chatter"), rospy.remap_name("other"), rospy.names.get_mappings().get("chatter"))
print(
    rospy.names.ns_join("/a", "b"),
    rospy.names.canonicalize_name("/a//b/"),
    rospy.names.scoped_name("/a/n", "/a/b/c"),
)
pub.publish("latched")
private = rospy.Publisher("~private", String, queue_size=1, latch=True)
private.publish("mine")
rospy.init_node("names", anonymous="--anonymous" in sys.argv)
try:
    rospy.init_node("another")
except rospy.ROSException as e:
    print(str(e).partition(":")[0])
for name in ("", "/a/b"):
    try:
        rospy.init_node(name)
    except ValueError as e:
        print(e)
print(sorted(map(tuple, rospy.get_published_topics())))
print(rospy.get_master().getUri()[:2], rospy.get_master().target is not None)
while rospy.get_param("/heard/ear", 0) < (1 if "--anonymous" in sys.argv else 2):
    rospy.sleep(0.01)
