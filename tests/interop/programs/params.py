"""Parameters: private, typed on the command line, trees, search, delete, missing ones."""

import rospy

print(rospy.get_param("/given/number", "before init_node"))
rospy.init_node("params")
print(rospy.get_param("~rate"), rospy.get_param("~name"), rospy.get_param("~list"), rospy.get_param("~on"))
print(repr(rospy.get_param("~half")), repr(rospy.get_param("~none", "default")))
rospy.set_param("~tree", {"a": 1, "b": {"c": [1.5, "x", True]}})
print(rospy.get_param("~tree/b/c"), rospy.has_param("~tree"), rospy.has_param("~no"))
rospy.set_param("plain", "text")
print(rospy.get_param("/plain"), rospy.search_param("plain"), rospy.search_param("nowhere"))
rospy.delete_param("plain")
try:
    rospy.get_param("plain")
except KeyError as e:
    print("KeyError", e)
try:
    rospy.delete_param("plain")
except KeyError as e:
    print("KeyError", e)
try:
    rospy.set_param("bad", None)
except TypeError as e:
    print("TypeError", e)
print(rospy.get_param_cached("~rate"), rospy.get_param("/given"))
print(sorted(n for n in rospy.get_param_names() if n.startswith("/params")))
print(rospy.myargv(["x", "_a:=1", "b:=c", "--real", "arg"]))
