"""Parameters of every type, from the command line, a namespace and the program."""

import rosgraph
import rospy

rospy.init_node("params")
for n in [
    "~port",
    "~baud",
    "~flag",
    "~off",
    "~neg",
    "~list",
    "~dict",
    "~str",
    "~exp",
    "~spaces",
    "~dict/a",
    "/robot",
    "/robot/name",
    "/robot/size",
    "/robot/deep/a/b",
    "/robot/deep",
    "local",
    "/speed",
    "/speed/x",
]:
    try:
        v = rospy.get_param(n)
        print(n, type(v).__name__, v)
    except KeyError as e:
        print(n, "KeyError", e, e.args)
for n in ["~empty"]:
    print(n, rospy.get_param(n, "dflt"))
print(rospy.has_param("~port"), rospy.has_param("nope"), rospy.has_param("/robot"))
print(
    rospy.search_param("local"),
    rospy.search_param("speed"),
    rospy.search_param("nope"),
    rospy.search_param("port"),
)
print(sorted(n for n in rospy.get_param_names() if "run_id" not in n and "ros" not in n.split("/")[1][:3]))
rospy.set_param("~new", {"x": 1, "y": [1, 2], "z": {"k": "v"}})
print(rospy.get_param("~new"), rospy.get_param("~new/z/k"))
rospy.set_param("~new/x", "changed")
print(rospy.get_param("~new"))
for v in [
    1,
    1.5,
    True,
    "text",
    "h\u00e9",
    [],
    {},
    [[1], [2]],
    (1, 2),
    b"bytes",
    -(2**31),
    2**31,
    None,
    {1: 2},
    object(),
    {"a": None},
    rospy.Time(1),
    float("inf"),
    "<&>",
    "",
    " lead",
    "a\nb",
]:
    try:
        rospy.set_param("v", v)
        r = rospy.get_param("v")
        print(
            repr(v) if not isinstance(v, object().__class__) or type(v) is not object else "obj",
            "->",
            type(r).__name__,
            repr(r),
        )
    except Exception as e:
        print(type(v).__name__, type(e).__name__, str(e).replace(hex(id(v)), ""))
rospy.delete_param("~new")
print(rospy.has_param("~new"))
try:
    rospy.delete_param("~new")
except KeyError as e:
    print("KeyError", e)
print(rospy.get_param("nope", None), rospy.get_param("nope", default=[1]))
print(rospy.get_param_cached("/speed"), rospy.get_param_cached("/speed"))
rospy.set_param("/speed", 0.75)
while rospy.get_param_cached("/speed") != 0.75:  # the master tells of it
    rospy.sleep(0.01)
print(rospy.get_param_cached("/speed"))
try:
    rospy.get_param_cached("nopec")
except KeyError as e:
    print("KeyError", e)
print(rospy.get_param_cached("nopec", 4), rospy.get_param_cached("nopec", default="q"))
m = rospy.get_master()
print(m["/speed"], "/speed" in m, "zz" in m, [x for x in m if x.startswith("/robot")])
try:
    rospy.get_param("")
except Exception as e:
    print(type(e), e)
try:
    rospy.get_param(None)
except Exception as e:
    print(type(e), e)
try:
    rospy.get_param(5)
except Exception as e:
    print(type(e), e)
print(rospy.get_param("~"))
print(rospy.get_param("/robot/", 1))
rospy.set_param("bad name!", 1)
print(rospy.get_param("bad name!"))
