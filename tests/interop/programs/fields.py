"""Fields by patterns, types of topics by longer names, and how genmsg spells types: also what is wrong with them."""

import sys
import threading

import rospy
import rostopic
from genmsg import InvalidMsgSpec
from genmsg.msgs import MsgSpec, is_valid_msg_type, parse_type
from geometry_msgs.msg import Pose, PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, String, UInt8MultiArray

sys.stderr = sys.stdout  # so that the order of both counts


def attempt(function, *arguments):
    try:
        return function(*arguments)
    except (ValueError, TypeError, AttributeError, AssertionError, InvalidMsgSpec) as error:
        return type(error).__name__, str(error)


def short(value):
    return type(value).__name__, str(value).replace("\n", " ")[:100]


array = Float64MultiArray(data=[1.0, 2.0, 3.0])
array.layout.dim = [MultiArrayDimension("a", 1, 2), MultiArrayDimension("b", 3, 4)]
path = Path(poses=[PoseStamped() for _ in range(3)])
for number, pose in enumerate(path.poses):
    pose.pose.position.x = number
messages = [
    LaserScan(ranges=[1.0, 2.0, 3.0, 4.0]),
    LaserScan(ranges=(1.0, 2.0, 3.0, 4.0)),
    path,
    array,
    UInt8MultiArray(data=b"abc"),
    String("abc"),
]
indexes = [
    "",
    "0",
    "-1",
    "1:3",
    "::2",
    ":",
    "1:",
    ":-1",
    "9",
    "9:",
    "x",
    "a:",
    ":a",
    "::a",
    "1:2:3:4",
    "::0",
    "1_0",
]
patterns = [
    "",
    "/",
    "//",
    "ranges",
    "/ranges",
    "/ranges[",
    "/ranges[1",
    "/ranges[1]x",
    "/ranges[0][1]",
    "/ranges/x",
]
patterns += ["/ranges[%s]" % index for index in indexes] + ["/data[%s]" % index for index in indexes]
patterns += ["/poses[%s]/pose/position/x" % index for index in indexes]
patterns += [
    "/header/seq",
    "/header/seq[0]",
    "/header/nothing/x",
    "/header/frame_id[0]",
    "/nothing",
    "/poses[:]/nothing",
]
patterns += ["/layout/dim[:]/label", "/layout/dim[:]/label[0]", "/poses[:][0]/pose", "/poses/pose"]
for pattern in patterns:
    function = rostopic.msgevalgen(pattern)
    print(repr(pattern), function is None)
    for message in messages if function else ():
        print(*short(attempt(function, message)))

for base in ("", "a", "a/b", "string", "Header", " ", "a b"):
    for tail in (
        "",
        "[",
        "]",
        "[]",
        "[3]",
        "[3",
        "[x]",
        "[-1]",
        "[0]",
        "[]]",
        "[][]",
        "[3][3]",
        "3]",
        "[3] ",
        "[ 3]",
    ):
        one = base + tail
        print(repr(one), attempt(parse_type, one), attempt(is_valid_msg_type, one), end=" ")
        print(attempt(lambda one=one: MsgSpec([one], ["x"], [], "", "p/T").parsed_fields()))
for types, names in ((["string"], []), ([], ["x"]), (["string", "string"], ["x", "x"]), (["string["], ["x"])):
    print(attempt(lambda types=types, names=names: MsgSpec(types, names, [], "", "p/T").fields()))

rospy.init_node("fields", disable_rosout=True)
kinds = {"/q": Pose, "/q/position": String, "/q/position/deep": Float64MultiArray, "/q2": String}
publishers = [rospy.Publisher(name, kind, queue_size=1) for name, kind in kinds.items()]
for topic in (
    *[
        "/q",
        "/q/",
        "/q/position",
        "/q/position/",
        "/q/position/x",
        "/q/position/data",
        "/q/orientation/w",
        "/q/nothing",
    ],
    *[
        "/q/position/deep/layout/dim[0]/size",
        "/q/position/deep/data[1:3]",
        "/q2",
        "/q2/data",
        "/q2x",
        "/none",
        "q",
    ],
):
    type_, name, function = rostopic.get_topic_type(topic)
    print(topic, type_, name, function is None)
    cls, name, function = rostopic.get_topic_class(topic)
    print(cls and cls._type, name, function is None)


def publish_late():
    publishers.append(rospy.Publisher("/late", String, queue_size=1))


threading.Timer(0.5, publish_late).start()
print(rostopic.get_topic_type("/late", blocking=True)[:2])
