# ruff: noqa: C416
"""Names remapped from the command line; rospy.names."""

import sys

import rospy
from std_msgs.msg import String

rospy.init_node("orig", anonymous=True)
print(rospy.get_name(), rospy.get_namespace(), rospy.get_caller_id())
print(rospy.myargv(), rospy.myargv(argv=["a", "b:=c", "--x"])) if False else print(
    [a for a in rospy.myargv()][1:], rospy.myargv(argv=["a", "b:=c", "--x"]), len(sys.argv)
)
for n in [
    "chatter",
    "/chatter",
    "foo",
    "~priv",
    "priv",
    "~foo",
    "/my/ns/foo",
    "x/foo",
    "",
    "~",
    "/",
    "foo/",
    "bar",
    "~p",
]:
    print(repr(n), rospy.resolve_name(n), rospy.remap_name(n))
print(rospy.resolve_name("x", "/a/b"), rospy.names.get_mappings(), rospy.names.get_resolved_mappings())
print(
    rospy.get_param("~p"),
    rospy.Publisher("chatter", String, queue_size=1).name,
    rospy.Subscriber("foo", String).name,
)
print(
    rospy.names.scoped_name("/a/b", "/a/c/d"),
    rospy.names.canonicalize_name("//a///b/"),
    rospy.names.is_global("/x"),
    rospy.names.is_private("~x"),
    rospy.names.is_legal_name("a b"),
    rospy.names.ns_join("/a", "b"),
    rospy.names.namespace("/a/b/c"),
)
for f in [
    lambda: rospy.names.scoped_name("a", "b"),
    lambda: rospy.names.namespace(None),
    lambda: rospy.names.namespace(5),
    lambda: rospy.names.get_ros_namespace(),
    lambda: rospy.names.load_mappings(["a:=b", "_c:=d", "__name:=e", "junk"]),
    lambda: rospy.names.resolve_name_without_node_name("x"),
]:
    try:
        print(f())
    except Exception as e:
        print(type(e).__name__, e)
